"""The page of a search for missing physics whose residual is a torque: `TorqueFinding` in, `Page` out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from haptid.discrepancy.finding.drawn import TorqueLeft
from haptid.discrepancy.finding.gap import tell_share
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.measurement.values.run import Array
from haptid.measurement.values.units import unit_for
from haptid.model.equations.quantity import Quantity
from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import with_error, write_gain
from haptid.report.common.page import Page, Picture, Section, Table
from haptid.report.common.style import ACCENT, BAND, MEASURED, SIMULATED, figure, style
from haptid.report.discrepancy.glance import torque_glance
from haptid.report.discrepancy.page import gap_rows, write_formulas, write_share
from haptid.report.discrepancy.where_pictures import localisation_picture
from haptid.support.linear_algebra import largest_magnitude, rms
from haptid.support.numbers import choose_unit, plain


def torque_picture(finding: TorqueFinding) -> Picture:
    """Draw measured and modelled torque over position, and the residual torque on held-out stretches.

    Parameters
    ----------
    finding
        Result of the search.

    Returns
    -------
    Picture
        All runs in one panel, the residual with ±2σ of the torque's noise below.
    """
    found = finding.search
    with style():
        made = figure(8.5, 4.6)
        top, low = made.subplots(2, 1, sharex=True, height_ratios=(1.3, 1))
        rows = found.study.moving
        # Where a joint just begins to move, stiff presliding may give any torque: the measured ones set the scale.
        measured = np.concatenate([run.y[counts, 0] for run, counts in zip(found.study.runs, rows, strict=True)])
        unit, factor = choose_unit(largest_magnitude(measured), _unit(finding, "N m"))
        for k, (run, counts, before, after) in enumerate(
            zip(found.study.runs, rows, found.base.residual, found.final.residual, strict=True)
        ):
            q, tau = (np.where(counts, of_run, np.nan) for of_run in (run.u[:, 0], run.y[:, 0]))
            hide = "_" if k else ""
            top.plot(q, factor * tau, color=MEASURED, lw=0.7, label=f"{hide}measured")
            top.plot(q, factor * (tau - before), color=ACCENT, ls="--", label=f"{hide}model before")
            top.plot(q, factor * (tau - after), color=SIMULATED, label=f"{hide}model after")
        top.set_ylim(*_range_of(factor * measured))
        draw_torque_left(low, TorqueLeft.of(finding), [found.study.prismatic])
        top.set_ylabel(f"torque [{unit}]")
        for axis in (top, low):
            axis.legend(fontsize=7)
    caption = (
        "Above: torque over position, without the rows at rest. Below: measured minus modelled torque on stretches "
        "that no fit saw; the band is ±2σ of the torque's noise. The table counts rows away from reversals, "
        "which name effects."
    )
    return picture_of(made, caption=caption, alt="torque over position, measured and modelled")


def _range_of(values: Array) -> tuple[float, float]:
    """Return the least and the largest value, and a quarter of the range more on either side."""
    low, high = (float(values.min()), float(values.max())) if values.size else (-1.0, 1.0)
    room = 0.25 * (high - low) or 1.0
    return low - room, high + room


def draw_torque_left(axis: Axes, left: TorqueLeft, prismatic: Sequence[bool]) -> None:
    """Draw the residual torque on held-out stretches over position, before and after the search.

    Parameters
    ----------
    axis
        Axes to draw on.
    left
        Residual torque of each run.
    prismatic
        Whether each joint is prismatic, for the units.
    """
    torques = [of_run[1:].ravel() for of_run in left.stretches]
    unit, factor = choose_unit(largest_magnitude(*torques, 2 * left.noise, left.largest), unit_for("N m", prismatic))
    for k, (q, before, after) in enumerate(left.stretches):
        hide = "_" if k else ""
        axis.plot(q, factor * before, ".", ms=2, color=ACCENT, label=f"{hide}left before")
        axis.plot(q, factor * after, ".", ms=2, color=SIMULATED, label=f"{hide}left after")
    axis.axhspan(*(2 * factor * s * left.noise for s in (-1, 1)), color=BAND, alpha=0.5, lw=0)
    axis.set_ylabel(f"held out, left [{unit}]")
    axis.set_xlabel(f"position [{unit_for('rad', prismatic)}]")


def remaining_picture(finding: TorqueFinding) -> Picture:
    """Draw the mean residual torque of the final model over position, for each direction of the motion.

    Parameters
    ----------
    finding
        Result of the search.

    Returns
    -------
    Picture
        One line a direction, with standard errors.
    """
    left = finding.remaining
    unit, factor = choose_unit(largest_magnitude(left.up, left.down, finding.largest_torque), _unit(finding, "N m"))
    with style():
        made = figure(8.5, 2.4)
        axis = made.subplots()
        for values, name, colour in ((left.up, "position grows", SIMULATED), (left.down, "position falls", ACCENT)):
            axis.errorbar(left.position, factor * values, factor * left.std, fmt="o-", ms=3, label=name, color=colour)
        axis.axhline(0.0, color=MEASURED, lw=0.6)
        axis.set_xlabel(f"position [{_unit(finding, 'rad')}]")
        axis.set_ylabel(f"left [{unit}]")
        axis.legend(fontsize=7)
    text = "Mean torque that the final model leaves, by position and direction, with standard errors."
    return picture_of(made, caption=text, alt="remaining torque over position")


def _gaps(finding: TorqueFinding) -> Table:
    shares = {name: tell_share(gap.closed, 0) for name, gap in finding.gaps.items()}
    shown, rows = gap_rows(finding.gaps, shares, "stretches", _unit(finding, "N m"), finding.largest_torque)
    unit = f"[{shown}]"
    header = ("", f"left before {unit}", f"left after {unit}", f"noise {unit}", "gap closed")
    return Table(header=header, rows=rows)


THROUGH_CONTROLLER = "refitted through the controller"


def _effects(finding: TorqueFinding) -> Table:
    final, loop = finding.search.final, finding.final_loop
    rows = []
    for effect in final.effects:
        for quantity in effect.parameters:
            if quantity.fixed:
                continue
            refitted = [] if loop is None else [_in_unit(f"{loop.values[quantity.id]:.4g}", quantity)]
            value = _value(final, quantity)
            rows.append((effect.id, quantity.id, value, *refitted, write_share(finding.stability, effect.key)))
    through = () if loop is None else (THROUGH_CONTROLLER,)
    return Table(header=("effect", "parameter", "value ± std", *through, "named in bags of stretches"), rows=rows)


def _nominal_parameters(finding: TorqueFinding) -> Table:
    """Write the nominal model's own parameters without and with the effects beside each other."""
    found, loop = finding.search, finding.final_loop
    rows = []
    for quantity in found.study.base.parameters:
        if not quantity.fixed:
            refitted = [] if loop is None else [_in_unit(f"{loop.values[quantity.id]:.4g}", quantity)]
            rows.append((quantity.id, _value(found.base, quantity), _value(found.final, quantity), *refitted))
    through = () if loop is None else (THROUGH_CONTROLLER,)
    return Table(header=("parameter", "without the effects", "with the effects", *through), rows=rows)


def _value(model: TorqueFit, quantity: Quantity) -> str:
    """Write a value with its error; a dash where that exceeds the range, so that the runs do not tell the value."""
    if model.std[quantity.id] > quantity.upper - quantity.lower:
        return "–"
    return _in_unit(with_error(model.values[quantity.id], model.std[quantity.id]), quantity)


def _in_unit(value: str, quantity: Quantity) -> str:
    return f"{value} {quantity.unit}".removesuffix(" 1")


def _rounds(finding: TorqueFinding) -> list[Table]:
    candidates = [candidate for step in finding.search.steps for candidate in step.candidates]
    largest = largest_magnitude(*(rms(candidate.model.unseen_away) for candidate in candidates), finding.largest_torque)
    unit, factor = choose_unit(largest, _unit(finding, "N m"))
    left = f"left there [{unit}]"
    return [
        Table(
            header=("entry", "gain in BIC", "evidence on held-out stretches", left, "taken"),
            rows=[
                (
                    c.key, write_gain(c.bic), write_gain(c.evidence),
                    plain(factor * rms(c.model.unseen_away), 3), "yes" if c is step.taken else "",
                )
                for c in step.candidates
            ],
            caption=f"Round {number}",
        )
        for number, step in enumerate(finding.search.steps, start=1)
    ]  # fmt: skip


def _unit(finding: TorqueFinding, unit: str) -> str:
    return unit_for(unit, [finding.search.study.prismatic])


def torque_gap_page(finding: TorqueFinding, title: str, *, measured: bool) -> Page:
    """Render the page.

    Parameters
    ----------
    finding
        Result of the search.
    title
        Title of the campaign.
    measured
        Whether the data are measured (else the page says SYNTHETIC DATA).

    Returns
    -------
    Page
        Content of the page.
    """
    found = finding.search
    tried = (
        f"{finding.considered} effects of the catalogue can be read from motion to torque"
        + ("" if found.study.repeats else " and told apart in a single sweep (those that live in time cannot)")
        + "; each round refits the most promising with all parameters. Evidence is twice the gain in log predictive "
        "score on stretches that no fit saw; BIC charges each parameter ln n."
    )
    settle = (
        "The torque of a position controller holds the joint where it is told to be, so the measured motion goes in "
        "and the torque is scored. One sweep at one speed does not tell viscous from dry friction, nor a torque bound "
        "to position from friction bound to position but by their signs: sweeps at two more speeds, and one with "
        "reversals in the middle of the travel, would."
    )
    where = localisation_picture(finding.maps, [found.study.prismatic])
    sections = [
        Section(title="Before and after", anchor="gap", pictures=[torque_picture(finding)], tables=[_gaps(finding)]),
        Section(
            title="What is missing",
            anchor="what",
            paragraphs=write_formulas(found.final.effects),
            tables=[_effects(finding), _nominal_parameters(finding)],
        ),
        Section(title="Where the gap was", anchor="where", pictures=[where]),
        Section(title="What is left", anchor="left", pictures=[remaining_picture(finding)]),
        Section(title="What would settle it", anchor="settle", paragraphs=[settle]),
        Section(title="What was tried", anchor="tried", paragraphs=[tried], tables=_rounds(finding)),
    ]
    return Page(
        title=f"Joint {found.study.joint}: {title}",
        lead=finding.sentence,
        sections=[s for s in sections if s.anchor != "what" or found.final.effects],
        synthetic=not measured,
        footer=[f"{found.simulations} simulations in {finding.wall_s:.0f} s."],
        glance=torque_glance(finding),
    )
