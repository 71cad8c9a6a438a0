"""Amplitude of every cycle of a run over the simulated one: `Run` and simulation in, `CycleAmplitudes` out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.values.run import Array, Run


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleAmplitudes:
    """Amplitudes of the cycles of one run.

    Parameters
    ----------
    file, use
        File of the run and its use.
    excess
        Amplitude of each cycle over the simulated one, less 1 [1], shape (n_cycles,).
    std
        Its standard deviation by the sensor's noise [1], shape (n_cycles,).
    """

    file: str
    use: str
    excess: Array
    std: Array

    @property
    def p_value(self) -> float:
        """Probability that the sensor's noise alone scatters the cycles about their mean as far."""
        weights = 1.0 / self.std**2
        mean = float(np.sum(weights * self.excess) / np.sum(weights))
        return float(chi2.sf(np.sum(weights * (self.excess - mean) ** 2), self.excess.size - 1))


def cycle_amplitudes(run: Run, simulated: Array) -> CycleAmplitudes | None:
    """Compare the amplitude of every cycle with the simulated one.

    Parameters
    ----------
    run
        Run with its torque, whose cycles are counted; its first joint counts.
    simulated
        Simulated readings of that joint, shape (n_t,).

    Returns
    -------
    CycleAmplitudes or None
        None where the torque is not periodic or has too few cycles. Within a cycle, the excess is the least-squares
        slope of the residual over the simulated signal about its mean.
    """
    scored = slice(run.score_from, None)
    index, measured, simulated = whole_cycles(run).index[scored], run.y[scored, 0], simulated[scored]
    excess, std = [], []
    for cycle in np.unique(index):
        rows = index == cycle
        shape = simulated[rows] - simulated[rows].mean()
        energy = float(shape @ shape)
        if rows.sum() < THRESHOLDS.least_rows_of_cycle_amplitude or not energy > 0:
            continue
        excess.append(float(shape @ (measured - simulated)[rows]) / energy)
        std.append(float(run.sensor_std[0]) / energy**0.5)
    if len(excess) < THRESHOLDS.least_cycles_of_amplitude_scatter:
        return None
    return CycleAmplitudes(file=run.file, use=run.use, excess=np.array(excess), std=np.array(std))
