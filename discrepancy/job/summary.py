"""A finding as JSON and in words: any finding in; content of its file, and what a command tells, out."""

from __future__ import annotations

from typing import Any

from haptid.discrepancy.finding.finding import Finding
from haptid.discrepancy.finding.finding import as_json as position_json
from haptid.discrepancy.finding.full_model import WholeFinding
from haptid.discrepancy.finding.gap import tell_share
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.finding.torque_json import torque_json
from haptid.discrepancy.job.search import AnyFinding
from haptid.measurement.values.units import unit_for
from haptid.support.numbers import plain
from haptid.support.tables import Table, Told


def finding_json(finding: AnyFinding, *, measured: bool, seed: int) -> dict[str, Any]:
    """Return the content of the file of a finding.

    Parameters
    ----------
    finding
        Finding of any kind.
    measured
        Whether the data were measured, not simulated.
    seed
        Seed of the search.

    Returns
    -------
    dict
        Fields of INTERFACES.
    """
    if isinstance(finding, WholeFinding):
        return finding.as_json(measured=measured)
    if isinstance(finding, TorqueFinding):
        return torque_json(finding, measured=measured, seed=seed)
    return position_json(finding, measured=measured, seed=seed)


def tell_finding(finding: AnyFinding, title: str, verdict: str) -> Told:
    """Tell verdict and gaps.

    Parameters
    ----------
    finding
        Finding of any kind.
    title
        What was searched, as ``joint 3``.
    verdict
        Verdict of INTERFACES.

    Returns
    -------
    list
        The verdict with its sentence, then a table with a row a gap (a line each in plain text), where there are gaps.
    """
    if isinstance(finding, Finding):
        gaps = [_gap_table(finding)] if finding.gaps else []
        return [f"{title}: {verdict}. {finding.judgement.sentence}", *gaps]
    told = f"{title}: {verdict}. {finding.sentence}"
    if isinstance(finding, WholeFinding):
        return [told]
    gap, unit = finding.gaps["validate"], unit_for("N m", [finding.search.study.prismatic])
    before, after, noise = plain(gap.before, 3), plain(gap.after, 3), plain(gap.noise, 3)
    line = f"  held-out torque: RMS {before} {unit}, noise {noise}"
    columns = {"error": before, "noise": noise}
    if finding.search.final.effects:
        line = f"  held-out torque: RMS {before} {unit} before, {after} after, noise {noise}"
        columns = {"before": before, "after": after, "noise": noise}
    header = (f"RMS [{unit}]", *columns)
    return [told, Table(header=header, rows=[("held-out torque", *columns.values())], plain=line)]


def _gap_table(finding: Finding) -> Table:
    unit = unit_for("rad", finding.search.study.fitted[0].prismatic)
    with_what = " with the stand-in" if finding.judgement.is_stand_in else ""
    rows, lines = [], []
    for name, gap in finding.gaps.items():
        share, beside = gap.closed_beside_scatter, "" if gap.beside is None else " beside the scatter"
        amounts = (plain(gap.before, 3), plain(gap.after, 3), plain(gap.noise, 3))
        closed = "–" if share is None else f"{tell_share(share)}{beside}"
        rows.append((name, *amounts, closed))
        told = "" if share is None else f", {tell_share(share)} of the gap{beside} closed"
        lines.append(f"  {name}: RMS {amounts[0]} before, {amounts[1]} after{with_what}, noise {amounts[2]}{told}")
    header = (f"RMS [{unit}]", "before", f"after{with_what}", "noise", "gap closed")
    return Table(header=header, rows=rows, plain="\n".join(lines))
