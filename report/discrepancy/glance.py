"""The first screen of a search: a finding in; a table with verdict, what it means and what to do out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.finding.finding import Curve, Finding
from haptid.discrepancy.finding.full_model import WholeFinding
from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.fit.solution import SCATTER
from haptid.discrepancy.verdict.verdict import Judgement
from haptid.measurement.values.units import unit_for
from haptid.report.common.numbers import in_thousandths
from haptid.report.common.page import Cell, Table
from haptid.report.common.words import word_of
from haptid.support.linear_algebra import rms
from haptid.support.numbers import plain

HEADER = (
    "joint", "verdict", "missing", "missed before", "missed after", "× noise", "worst run", "what to do next", "files",
)  # fmt: skip
MAKE_THE_RUN = "Make the run that the page proposes, and search again."
EITHER_SERVES = "Either model serves: choose by what is known of the machine."
JOINTS_ALONE = "Test each of the joints alone, and search again."
RIVALS_BY_SPEED = "Make the sweeps that the page proposes, and search again."
SCATTER_ACTION = "Use the model as it is; haptid posterior gives bands that hold the scatter."


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """What a line tells.

    ``names`` is empty where nothing was changed, ``random`` says that no simulation can follow it, and ``beside`` is
    the drive's torque, where residuals are torques.
    """

    joint: str
    verdict: str
    names: str
    gap: Gap
    unit: str
    worst: str
    action: str
    links: list[str]
    random: bool = False
    beside: float = 0.0


def is_scatter_alone(finding: Finding) -> bool:
    """Say whether all that is missing is random from cycle to cycle.

    Parameters
    ----------
    finding
        Result of the search.

    Returns
    -------
    bool
        False where nothing is missing.
    """
    effects = finding.judgement.effects
    named = finding.judgement.verdict in ("named", "ambiguous")
    return named and bool(effects) and all(effect.id.endswith(SCATTER) for effect in effects)


def position_glance(finding: Finding) -> Table:
    """Write the line of a search in the position.

    Parameters
    ----------
    finding
        Result of the search.

    Returns
    -------
    Table
        Residuals of the runs that took part in the fewest choices.
    """
    verdict = finding.judgement.verdict
    gap = next(finding.gaps[name] for name in ("sealed", "validate", "fit") if name in finding.gaps)
    unit = unit_for("rad", finding.search.study.fitted[0].prismatic)
    changed = verdict != "nothing_missing" and bool(finding.judgement.effects)
    links = [f"{finding.search.study.name}.json"]
    if finding.rebuilt is not None:
        links.append(f"../fmu/{finding.rebuilt.fmu.path.name}")
    # What only stands in for it is no finding: the section on it has its names.
    named = changed and verdict != "unlisted"
    names = ", ".join(dict.fromkeys(e.id for e in finding.judgement.effects)) if named else ""
    action = SCATTER_ACTION if is_scatter_alone(finding) else _next_action(finding.judgement)
    joints = ", ".join(map(str, finding.joints))
    return _table_of(
        _Line(
            joint=joints, verdict=verdict, names=names, gap=gap, unit=unit,
            worst=_worst_run(finding.curves, changed=changed), action=action, links=links,
            random=is_scatter_alone(finding),
        )
    )  # fmt: skip


def _next_action(judgement: Judgement) -> str:
    """Say what to do: between rivals, what the proposed run can tell decides."""
    if judgement.verdict != "ambiguous":
        return word_of(f"verdict-{judgement.verdict}").action
    if judgement.next_experiment is None:
        return JOINTS_ALONE
    return MAKE_THE_RUN if judgement.next_experiment.tells else EITHER_SERVES


def torque_glance(finding: TorqueFinding) -> Table:
    """Write the line of a search in the torque.

    Parameters
    ----------
    finding
        Result of the search.

    Returns
    -------
    Table
        Residuals of the stretches that took part in the fewest choices.
    """
    verdict, found = finding.verdict, finding.search
    gap = next(finding.gaps[name] for name in ("sealed", "validate", "fit") if name in finding.gaps)
    sizes = [rms(residual) for residual in found.final.residual]
    worst = found.study.runs[int(np.argmax(sizes))].file
    links = [f"joint{found.study.joint}.json"]
    if finding.fmu is not None:
        links.append(f"../fmu/{finding.fmu.path.name}")
    names = ", ".join(dict.fromkeys(e.id for e in found.final.effects))
    unit = unit_for("N m", [found.study.prismatic])
    action = RIVALS_BY_SPEED if verdict == "ambiguous" else word_of(f"verdict-{verdict}").action
    return _table_of(
        _Line(
            joint=str(found.study.joint), verdict=verdict, names=names, gap=gap, unit=unit, worst=worst, action=action,
            links=links, beside=finding.largest_torque,
        )
    )  # fmt: skip


def whole_glance(finding: WholeFinding) -> Table:
    """Write one line for each joint of the whole device.

    Parameters
    ----------
    finding
        Residuals of every run and joint.

    Returns
    -------
    Table
        The run that each joint is missed most in, after the search.
    """
    word = word_of(f"verdict-{finding.verdict}")
    rows = []
    for joint in dict.fromkeys(row.joint for row in finding.rows):
        own = [row for row in finding.rows if row.joint == joint]
        worst = max(own, key=lambda row: row.after)
        unit = unit_for("rad", [worst.prismatic])
        rows.append((
            str(joint), Cell(text=word.text, word=word.key), ", ".join(finding.names) or "–",
            in_thousandths(worst.before, unit), in_thousandths(worst.after, unit), plain(worst.after / worst.noise, 3),
            f"{worst.file} ({worst.mode.replace('_', ' ')})", word.action,
        ))  # fmt: skip
    return Table(header=HEADER[:-1], rows=rows)


def _worst_run(curves: tuple[Curve, ...], *, changed: bool) -> str:
    """Return the run that the final model misses most, the nominal one where nothing was changed."""
    worst = max(curves, key=lambda c: float(np.mean((c.run.y[:, 0] - (c.after if changed else c.before)) ** 2)))
    return f"{worst.run.file} ({worst.run.use})"


def _table_of(line: _Line) -> Table:
    word = word_of(f"verdict-{line.verdict}")
    last = line.gap.after if line.names else line.gap.before
    before, after = (in_thousandths(rms, line.unit, line.beside) for rms in (line.gap.before, line.gap.after))
    if not line.names:
        after = "–"
    if line.random:
        after = "as before: it is random"
    row = (
        line.joint, Cell(text=word.text, word=word.key), line.names or "–", before,
        after, plain(last / line.gap.noise, 3), line.worst, line.action, Cell(links=line.links),
    )  # fmt: skip
    return Table(header=HEADER, rows=[row])
