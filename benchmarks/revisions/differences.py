"""How far two results of one command are apart, and which of them is nearer to what is true."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

ROUNDING = 1e-9
"""Relative difference of an RMS below which neither side is called better: sums in another order differ by less."""


@dataclass(frozen=True, slots=True)
class Largest:
    """The largest relative difference of some figures, and which of them differs by it; no name without figures."""

    difference: float
    name: str


def relative(before: float, after: float) -> float:
    """Return the difference over the larger of two numbers; 0 for two zeros.

    Examples
    --------
    >>> relative(2.0, 1.0), relative(0.0, 0.0)
    (0.5, 0.0)
    """
    scale = max(abs(before), abs(after))
    return abs(before - after) / scale if scale > 0 else 0.0


def largest_of_parameters(before: Mapping[str, Any], after: Mapping[str, Any]) -> Largest:
    """Return the largest relative difference of parameters that both figures hold."""
    both = before["parameters"].keys() & after["parameters"].keys()
    return _largest({id: relative(before["parameters"][id][0], after["parameters"][id][0]) for id in both})


def largest_in_errors(before: Mapping[str, Any], after: Mapping[str, Any]) -> Largest:
    """Return the largest difference of a parameter in standard errors of the earlier result."""
    both = before["parameters"].keys() & after["parameters"].keys()
    apart = {}
    for id in both:
        (old, std), (new, _) = before["parameters"][id], after["parameters"][id]
        if std:
            apart[id] = abs(old - new) / std
    return _largest(apart)


def largest_of_unseen(before: Mapping[str, Any], after: Mapping[str, Any]) -> Largest:
    """Return the largest relative difference of the RMS on unseen runs that both figures hold."""
    both = before["unseen"].keys() & after["unseen"].keys()
    return _largest({file: relative(before["unseen"][file], after["unseen"][file]) for file in both})


def _largest(differences: Mapping[str, float]) -> Largest:
    if not differences:
        return Largest(0.0, "")
    name = max(sorted(differences), key=lambda key: differences[key])
    return Largest(differences[name], name)


def largest_of_numbers(before: Any, after: Any) -> Largest:
    """Return the largest relative difference of all numbers that two JSON contents hold at the same place.

    Examples
    --------
    >>> largest_of_numbers({"fit": [1.0, 2.0], "files": "a"}, {"fit": [1.0, 4.0], "files": "b"})
    Largest(difference=0.5, name='fit.1')
    """
    old, new = dict(_numbers(before, "")), dict(_numbers(after, ""))
    return _largest({place: relative(old[place], new[place]) for place in old.keys() & new.keys()})


def _numbers(content: Any, place: str) -> Iterator[tuple[str, float]]:
    """Yield the numbers of JSON with the keys and positions that lead to them."""
    if isinstance(content, (dict, list)):
        for key, value in content.items() if isinstance(content, dict) else enumerate(content):
            yield from _numbers(value, f"{place}.{key}" if place else str(key))
    elif isinstance(content, (int, float)) and not isinstance(content, bool):
        yield place, float(content)


def rms_of_unseen(figures: Mapping[str, Any]) -> float | None:
    """Return the RMS over all unseen runs; None without any."""
    values = list(figures["unseen"].values())
    return math.sqrt(sum(value**2 for value in values) / len(values)) if values else None


def distance_from_truth(figures: Mapping[str, Any], truth: Mapping[str, float]) -> float | None:
    """Return the RMS of the relative errors of known parameters; None where no parameter's true value is known.

    Parameters
    ----------
    figures
        With ``parameters``, by id value and standard error.
    truth
        True values of the virtual device by id, SI units; zeros are left out.
    """
    errors = [(row[0] - truth[id]) / truth[id] for id, row in figures["parameters"].items() if truth.get(id)]
    return math.sqrt(sum(error**2 for error in errors) / len(errors)) if errors else None


def better(before: float | None, after: float | None) -> str:
    """Return which side has the smaller number: ``before``, ``after``, or nothing where they agree or one lacks."""
    if before is None or after is None or relative(before, after) <= ROUNDING:
        return ""
    return "after" if after < before else "before"
