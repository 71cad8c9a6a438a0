"""A finding as JSON and in words: any finding in; content of its file, and the lines that a command prints, out."""

from __future__ import annotations

from typing import Any

from haptid.discrepancy.finding.finding import Finding
from haptid.discrepancy.finding.finding import as_json as position_json
from haptid.discrepancy.finding.full_model import WholeFinding
from haptid.discrepancy.finding.torque_finding import TorqueFinding, torque_json
from haptid.discrepancy.job.search import AnyFinding
from haptid.measurement.values.units import unit_for


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


def tell_finding(finding: AnyFinding, title: str, verdict: str) -> str:
    """Write verdict and gaps in a few lines.

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
    str
        The verdict with its sentence, then a line for each gap.
    """
    if isinstance(finding, Finding):
        return "\n".join([f"{title}: {verdict}. {finding.judgement.sentence}", *_gap_lines(finding)])
    told = f"{title}: {verdict}. {finding.sentence}"
    if isinstance(finding, WholeFinding):
        return told
    gap, unit = finding.gaps["validate"], unit_for("N m", [finding.search.study.prismatic])
    return (
        f"{told}\n  held-out torque: RMS {gap.before:.3g} {unit} before, {gap.after:.3g} after, "
        f"white noise {gap.noise:.3g}"
    )


def _gap_lines(finding: Finding) -> list[str]:
    lines = []
    for name, gap in finding.gaps.items():
        share, beside = gap.closed_beside_scatter, "" if gap.beside is None else " beside the scatter"
        closed = "" if share is None else f", {100 * share:.1f} % of the gap{beside} closed"
        lines.append(
            f"  {name}: RMS {gap.before:.3g} before, {gap.after:.3g} after, noise {gap.noise:.3g}{closed}"
        )  # fmt: skip
    return lines
