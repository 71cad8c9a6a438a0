"""What a run of a case came to, and what differs between two of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Outcome = Mapping[str, Any]
"""Fields ``verdict``, ``names``, ``closed``, ``times_noise``, ``simulations`` and ``values`` (value and standard error
by name), or ``failed`` with the reason."""
LEAST_CLOSED, LEAST_NOISE, LEAST_SIMULATIONS, LEAST_STANDARD_ERRORS = 0.01, 0.05, 0.1, 1.0
"""Change of the closed share, relative changes of the times the noise and of the simulations, and shift of an
identified value in its standard errors, beyond which something changed."""
RULES = (
    f"An outcome changes where the verdict or a name does, the closed share by more than {LEAST_CLOSED:g}, the "
    f"residual of unseen runs over the noise by more than {LEAST_NOISE:.0%}, or an identified value by more than "
    f"{LEAST_STANDARD_ERRORS:g} standard error of the delivered run. Simulations are told where they change by more "
    f"than {LEAST_SIMULATIONS:.0%}; they are a cost and no outcome."
)


def differences(delivered: Outcome, other: Outcome) -> list[str]:
    """Return what changed in the outcome, one phrase each.

    Parameters
    ----------
    delivered, other
        Outcomes of one case.

    Returns
    -------
    list of str
        Empty where nothing changed.
    """
    if "failed" in other or "failed" in delivered:
        return [] if other.get("failed") == delivered.get("failed") else [f"no result: {other.get('failed')}"]
    told = []
    if other["verdict"] != delivered["verdict"]:
        told.append(f"{delivered['verdict']} → {other['verdict']}")
    if other["names"] != delivered["names"]:
        told.append(_changed_names(delivered["names"], other["names"]))
    told += _changed_figures(delivered, other)
    return told + _moved_values(delivered["values"], other["values"])


def cost_ratio(delivered: Outcome, other: Outcome) -> float | None:
    """Compare the effort of two runs of a case.

    Parameters
    ----------
    delivered, other
        Outcomes of one case.

    Returns
    -------
    float or None
        Simulations over those of the delivered run [1]; None where they differ by at most `LEAST_SIMULATIONS`, or one
        is not known.
    """
    before, after = delivered.get("simulations"), other.get("simulations")
    if not before or after is None or abs(after / before - 1.0) <= LEAST_SIMULATIONS:
        return None
    return float(after / before)


def _changed_names(before: list[str], after: list[str]) -> str:
    gone = [f"without {name}" for name in before if name not in after]
    new = [f"with {name}" for name in after if name not in before]
    return ", ".join(gone + new) or "other order of names"


def _changed_figures(before: Outcome, after: Outcome) -> list[str]:
    told = []
    for name, words, close in (
        ("closed", "closed share", _same_share),
        ("times_noise", "times the noise", _same_ratio),
    ):
        old, new = before[name], after[name]
        if old is None and new is None:
            continue
        if old is None or new is None or not close(old, new):
            told.append(f"{words} {_word_value(old)} → {_word_value(new)}")
    return told


def _same_share(old: float, new: float) -> bool:
    return abs(new - old) <= LEAST_CLOSED


def _same_ratio(old: float, new: float) -> bool:
    return abs(new - old) <= LEAST_NOISE * abs(old)


def _word_value(value: float | None) -> str:
    return "none" if value is None else f"{value:.3g}"


def _moved_values(before: Mapping[str, list[float]], after: Mapping[str, list[float]]) -> list[str]:
    """Tell the value that moved most, in standard errors, where any moved by more than one; and how many did."""
    moves = {
        name: abs(after[name][0] - value) / std for name, (value, std) in before.items() if name in after and std > 0
    }
    moved = {name: by for name, by in moves.items() if by > LEAST_STANDARD_ERRORS}
    if not moved:
        return []
    most = max(moved, key=lambda name: moved[name])
    others = f", {len(moved) - 1} more" if len(moved) > 1 else ""
    return [f"{most} by {moved[most]:.2g} standard errors{others}"]
