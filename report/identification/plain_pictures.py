"""Picture of a run as fit and plain model predict it: `Prediction` in, `Picture` out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.identification.baseline.prediction import Prediction
from haptid.measurement.values.run import Array
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.page import Picture
from haptid.report.common.style import ACCENT, MEASURED, SIMULATED, figure, style

LOOKS = {"model": (SIMULATED, "fit", "-"), "baseline": (ACCENT, "plain model", "--")}
"""Colour, name and line of each model."""


def plain_picture(prediction: Prediction) -> Picture:
    """Draw torque and free simulation of one run by both models.

    Parameters
    ----------
    prediction
        Signals of the run.

    Returns
    -------
    Picture
        What `plain_figure` draws.
    """
    caption = (
        f"{prediction.file}, which no fit saw. Left: torque as measured (grey) and as computed along the measured "
        "motion, all filtered alike. Right: position as measured, and simulated under the recorded torque alone. "
        "Below: measured minus computed."
    )
    alt = f"fit and plain model on {prediction.file}, with residuals"
    return picture_of(plain_figure(prediction), caption=caption, alt=alt)


def plain_figure(prediction: Prediction) -> Figure:
    """Draw torque and free simulation of one run by both models, each with its residual below.

    Parameters
    ----------
    prediction
        Signals of the run.

    Returns
    -------
    Figure
        Torque at the left, position at the right.
    """
    n = len(prediction.joints)
    with style():
        made = figure(9.0, 3.6 * n + 0.4)
        axes = made.subplots(2 * n, 2, sharex=True, squeeze=False, height_ratios=[2, 1] * n)
        for k, joint in enumerate(prediction.joints):
            torque, position = (unit_for(unit, [prediction.prismatic[k]]) for unit in ("N m", "rad"))
            pair = (axes[2 * k][0], axes[2 * k + 1][0])
            _draw(pair, prediction.torque_t, prediction.torque, prediction.computed, k)
            pair[0].set_ylabel(f"{'force' if torque == 'N' else 'torque'} {joint} [{torque}]")
            pair[1].set_ylabel(f"residual [{torque}]")
            pair = (axes[2 * k][1], axes[2 * k + 1][1])
            _draw(pair, prediction.position_t, prediction.position, prediction.simulated, k)
            pair[0].set_ylabel(f"position {joint} [{position}]")
            pair[1].set_ylabel(f"residual [{position}]")
        axes[0][0].set_title("computed along the measured motion", fontsize=8)
        axes[0][1].set_title("free simulation from the measured start", fontsize=8)
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        handles, labels = axes[0][0].get_legend_handles_labels()
        made.legend(handles, labels, loc="outside lower center", ncols=3)
    return made


def _draw(axes: tuple[Axes, Axes], t: Array, measured: Array, models: Mapping[str, Array], k: int) -> None:
    """Draw one signal of the joint at index k above, and what each model leaves of it below."""
    above, below = axes
    above.plot(t, measured[:, k], color=MEASURED, label="measured", linewidth=3.0, alpha=0.35)
    for name, signal in models.items():
        colour, label, line = LOOKS[name]
        above.plot(t, signal[:, k], color=colour, label=label, linestyle=line)
        below.plot(t, (measured - signal)[:, k], color=colour, label=label, linewidth=0.7)
    # A simulation that runs away would flatten the measured signal to a line.
    # A signal that never changes has no range; any will do.
    middle, reach = float(np.mean(measured[:, k])), float(np.ptp(measured[:, k])) or 1.0
    above.set_ylim(middle - reach, middle + reach)
    low, high = np.clip(below.get_ylim(), -reach, reach)
    if low < high:
        below.set_ylim(low, high)
