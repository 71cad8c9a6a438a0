"""Section on the whole device: `Verification` in, measured motion of all joints with bands of posterior draws out."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from haptid.identification.verification.result import RunCheck, Verification
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.page import Section, Table
from haptid.report.common.style import BAND, MEASURED, SIMULATED, figure, style


def full_model_sections(verification: Verification) -> list[Section]:
    """Return the section on all runs with all joints free.

    Parameters
    ----------
    verification
        Simulations of the runs by posterior draws.

    Returns
    -------
    list of Section
        One section; empty where there are no such runs.
    """
    if not verification.runs:
        return []
    unit = unit_for("rad", [j.prismatic for check in verification.runs for j in check.joints])
    header = ["joint", f"residual [{unit}]", f"spread of the draws [{unit}]", "residual over √(noise² + spread²)"]
    pictures, tables = [], []
    for check in verification.runs:
        caption = f"{check.file}, {check.mode.replace('_', ' ')}: {check.sentence}; {check.draws} draws."
        pictures.append(picture_of(full_model_figure(check), caption=caption, alt="all joints free"))
        rows = [
            [str(j.joint), f"{j.rmse_rad:.2g}", f"{j.spread_rad:.2g}", f"{j.over_expected:.2g}"] for j in check.joints
        ]
        tables.append(Table(header=header, rows=rows, caption=f"{check.file}, {check.mode.replace('_', ' ')}"))
    text = (
        "Draws of all joints' posteriors, combined with physically consistent links, run the whole model. Bands are ±2 "
        "standard deviations of the draws, without sensor noise."
    )
    return [Section(title="All joints free", anchor="full", paragraphs=[text], pictures=pictures, tables=tables)]


def full_model_figure(check: RunCheck) -> Figure:
    """Draw the position of every joint: measured, simulated, and the band of ±2 standard deviations of the draws.

    Parameters
    ----------
    check
        Verification of one run.

    Returns
    -------
    Figure
        Two columns of joints; the band is left out where fewer than two draws stayed finite.
    """
    n = check.measured.shape[1]
    with style():
        made = figure(9.0, 1.5 * -(-n // 2))
        axes = made.subplots(-(-n // 2), 2, squeeze=False).ravel()
        for i, ax in enumerate(axes):
            ax.set_visible(i < n)
            if i >= n:
                continue
            low, high = check.simulated[:, i] - 2 * check.spread[:, i], check.simulated[:, i] + 2 * check.spread[:, i]
            if np.isfinite(low).all():  # the spread is NaN where fewer than two draws stayed finite
                ax.fill_between(check.t, low, high, color=BAND, lw=0)
            ax.plot(check.t, check.measured[:, i], color=MEASURED, lw=0.8)
            ax.plot(check.t, check.simulated[:, i], color=SIMULATED, lw=0.8, ls="--")
            unit = unit_for("rad", [check.joints[i].prismatic])
            ax.set_title(f"joint {check.joints[i].joint} [{unit}]", fontsize=7, loc="left")
    return made
