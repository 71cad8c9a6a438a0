"""Picture of the amplitudes of cycles: `CycleAmplitudes` in, `Picture` out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.identification.output.cycle_amplitudes import CycleAmplitudes
from haptid.measurement.values.run import Array
from haptid.report.common.charts import picture_of
from haptid.report.common.marks import tell
from haptid.report.common.numbers import HALF_WIDTH_95
from haptid.report.common.page import Picture
from haptid.report.common.style import ACCENT, MEASURED, SIMULATED, figure, style


def cycles_picture(amplitudes: Sequence[CycleAmplitudes], title: str) -> Picture:
    """Draw the amplitudes of the cycles of runs.

    Parameters
    ----------
    amplitudes
        Amplitudes of the cycles of each run.
    title
        Name of the configuration.

    Returns
    -------
    Picture
    """
    caption = (
        f"{title}: amplitude of each cycle over the simulated one, less 1, with ±1.96 standard deviations by the "
        "sensor's noise. Amplitudes that stand further apart scatter from cycle to cycle."
    )
    return picture_of(cycles_figure(amplitudes), caption=caption, alt=f"{title}, amplitudes of cycles")


def cycles_figure(amplitudes: Sequence[CycleAmplitudes]) -> Figure:
    """Draw the amplitudes of cycles, run after run.

    Parameters
    ----------
    amplitudes
        Amplitudes of the cycles of each run.

    Returns
    -------
    Figure
    """
    with style():
        made = figure(8.5, 2.6)
        axis = made.subplots()
        place = 0
        for one in amplitudes:
            at = place + np.arange(one.excess.size, dtype=float)
            colour = SIMULATED if one.use == "fit" else ACCENT
            axis.errorbar(at, 100 * one.excess, 100 * HALF_WIDTH_95 * one.std, fmt="o", ms=3, lw=1, color=colour)
            tell_cycles(axis, at, f"{one.file} ({one.use})", one.excess, one.std)
            axis.text(place, 1.0, one.file, fontsize=6, rotation=15, transform=axis.get_xaxis_transform())
            place += one.excess.size + 1
        axis.axhline(0.0, color=MEASURED, lw=0.6)
        axis.set_xlabel("cycle, run after run (orange: no fit saw the run)")
        axis.set_ylabel("amplitude − 1 [%]")
    return made


def tell_cycles(axis: Axes, at: Array, run: str, excess: Array, std: Array) -> None:
    """Let a page tell the amplitude of each cycle of a run, with its 95 % interval.

    Parameters
    ----------
    axis
        Axes that show the amplitudes in percent.
    at
        Abscissas of the cycles, shape (n_cycles,).
    run
        Name of the run.
    excess, std
        Amplitudes less 1, and their standard deviations [1], shape (n_cycles,) each.
    """
    for k, (x, mean, error) in enumerate(zip(at, excess, std, strict=True), start=1):
        tell(axis, float(x), 100 * float(mean), f"{run}, cycle {k}: {100 * mean:+.3g} ± {196 * error:.2g} %")
