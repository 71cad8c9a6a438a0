"""What a page says of a study of the stranger beyond other studies: rules of the score, size and noise of each case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from studies.blind.outcome import RIGHT
from studies.hidden.kinds import KINDS

Row = dict[str, Any]
SAID = """\
The machine is a stranger on purpose: friction by four laws, none of them LuGre's, and disturbances by formulas that are
not the catalogue's, with coloured noise in a third of the cases, a stated noise that is off by up to a fifth or
missing, jitter, smoothing and encoder steps. Its ranges (`virtual_device/stranger/ranges.toml`), the table of kinds
(`studies/hidden/kinds.py`) and the rules of the score (`studies/blind/stranger.py`) were written down before the first
run. A name is right if it is the kind that was hidden. A friction law of which a refit of LuGre friction leaves at
least a tenth of the noise counts as hidden: alone, the right verdict is `unlisted`, `ambiguous` or the kind of friction
(`friction_law`; `stribeck_shape` where the stranger's curve is no Gaussian); beside an effect, the effect has to be
named all the same, and the kind of friction is passed over.

Since 2026-11-26 haptid's Dahl law has the stranger's exponent, and its Maxwell-slip law as many springs, whose
stiffness and limits fall as the stranger's do, though they stick and slip without a jump: for these two laws the
classes are near.

Sizes: `large` cases hide nothing of which a refit leaves less than twice the noise; sizes are drawn from where it
leaves a fifth of the noise to 0.6 of the motion, over the number of effects.
"""


def describe_cases(cases: Sequence[Row], labels: Sequence[Row]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return a table of all cases with what their labels say.

    Parameters
    ----------
    cases
        Cases of the study's JSON.
    labels
        Labels of the study.

    Returns
    -------
    header : tuple of str
    rows : list of tuple of str
        One row a case, in their order.
    """
    header = (
        "case",
        "hidden: over the noise after a refit, share of the motion",
        "friction law",
        "noise",
        "verdict",
        "",
    )
    known = {label["case"]: label for label in labels}
    rows: list[tuple[str, ...]] = []
    for case in cases:
        label = known[case["case"]]
        told = " ".join([case["verdict"], *case.get("names", ())])
        right = "right" if case["result"] in RIGHT else case["result"]
        rows.append((case["case"], _word_hidden(label), _friction(label), _noise(label), told, right))
    return header, rows


def _word_hidden(label: Row) -> str:
    left, share = label["left_over_noise"], label["share_of_motion"]
    parts = [f"{name} {left[name]:.2g}, {100 * share[name]:.2g} %" for name in label["hidden"]]
    return "; ".join(parts) or "nothing"


def _friction(label: Row) -> str:
    return f"{label['friction']['law']}, leaves {label['friction_law_left_over_noise']:.2g}"


def _noise(label: Row) -> str:
    recorder = label["recorder"]
    parts = ["coloured" if recorder["coloured"] else "white"]
    parts += ["jitter"] if recorder["jitter"] else []
    parts += ["smoothed"] if recorder["smoothing"] > 1 else []
    return ", ".join([*parts, "stated" if label["stated"] else "not stated"])


def count_kinds(cases: Sequence[Row], labels: Sequence[Row]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return a table of the kinds: how often each was hidden, and how often it was among the names.

    Parameters
    ----------
    cases
        Cases of the study's JSON.
    labels
        Labels of the study.

    Returns
    -------
    header : tuple of str
    rows : list of tuple of str
        One row a kind that was hidden.
    """
    known = {label["case"]: label for label in labels}
    hidden: dict[str, list[Mapping[str, Any]]] = {}
    for case in cases:
        for name in known[case["case"]]["effects"]:
            hidden.setdefault(name, []).append(case)
    rows: list[tuple[str, ...]] = []
    for name in sorted(hidden):
        among = [case for case in hidden[name] if KINDS[name][0] in case.get("names", ())]
        verdicts = ", ".join(case["result"] for case in hidden[name])
        rows.append((name, ", ".join(KINDS[name]), str(len(hidden[name])), str(len(among)), verdicts))
    return ("hidden", "names that are right", "cases", "named", "results"), rows
