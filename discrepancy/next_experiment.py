"""The run that would tell rivals apart: the cosine, within the torque already used, at which they differ most.

T-optimality (Atkinson and Fedorov 1975) over a grid of amplitude, frequency and offset, both models simulated at their
optimum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discrepancy.solution import Solution
from discrepancy.study import Study
from measurement.cycles import find_cycles
from measurement.run import Array, Run

AMPLITUDES, OFFSETS, FASTER = (0.5, 1.0), (0.0, 0.3), (0.5, 1.0, 2.0, 4.0, 8.0)
ROWS_A_PERIOD = 8
"""Readings that a period of the proposed torque holds at least."""
MANY = 20
"""Repeats of a run beyond which it is no help."""
CLEAR = 20.0
"""Expected evidence, twice the difference of log-likelihoods, at which the run tells the rivals apart."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """A cosine torque, the RMS difference of the rivals' readings over the sensor's noise, and the run's readings."""

    amplitude: float
    frequency: float
    offset: float
    separation: float
    rows: int

    @property
    def repeats(self) -> int:
        """How many such runs tell the rivals apart: their evidence is separation² for every reading."""
        return max(1, math.ceil(CLEAR / max(self.separation**2 * self.rows, 1e-6)))

    @property
    def tells(self) -> bool:
        """Whether a few such runs tell the rivals apart."""
        return self.repeats <= MANY

    def as_json(self) -> dict[str, float | str]:
        """Return the run in SI units and in words."""
        words = (
            f"cosine torque of {self.amplitude:.3g} N m at {self.frequency:.3g} rad/s "
            f"about {self.offset:.3g} N m, from rest"
        )
        if not self.tells:
            words += f"; it separates them by {self.separation:.2g} of the noise, no run within these limits would do"
        elif self.repeats > 1:
            words += f", {self.repeats} times: one alone separates them by {self.separation:.2g} of the noise"
        return {
            "torque_amplitude_Nm": self.amplitude, "frequency_rad_s": self.frequency, "torque_offset_Nm": self.offset,
            "separation_over_noise": self.separation, "run": words,
        }  # fmt: skip


def propose(study: Study, winner: Solution, rivals: Sequence[Solution]) -> Proposal:
    """Return the run of the grid at which the least separated rival differs most from the winner."""
    template = max(study.fitted, key=lambda run: run.t[-1])
    largest = max(float(np.abs(run.u).max()) for run in study.fitted)
    fastest = max(find_cycles(run).omega for run in study.fitted)
    limit = 2 * np.pi / (ROWS_A_PERIOD * float(np.median(np.diff(template.t))))
    grid = [
        (a * largest, fastest * f, o * largest)
        for a in AMPLITUDES
        for f in FASTER
        for o in OFFSETS
        if a + o <= 1.0 + 1e-9 and (fastest * f <= limit or f <= 1.0)
    ]
    tried = [
        Proposal(
            amplitude=a,
            frequency=w,
            offset=o,
            separation=_separation(study, winner, rivals, _cosine(template, a, w, o)),
            rows=template.t.size,
        )
        for a, w, o in grid
    ]
    return max(tried, key=lambda p: p.separation)


def _cosine(template: Run, amplitude: float, omega: float, offset: float) -> Run:
    u = offset + amplitude * np.cos(omega * template.t)
    return template.but(file="proposed", u=u[:, None], v=None, extra={})


def _separation(study: Study, winner: Solution, rivals: Sequence[Solution], run: Run) -> float:
    reference = _reading(study, winner, run)
    differences = [np.sqrt(np.mean((_reading(study, r, run) - reference) ** 2)) for r in rivals]
    return float(min(differences) / run.sensor_std[0])


def _reading(study: Study, solution: Solution, run: Run) -> Array:
    return study.factory(solution.equations).simulate(solution.theta, run).y[:, 0]
