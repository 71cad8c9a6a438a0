"""The ranges of ``ranges.toml``: everything that a case of the stranger is drawn from."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

Drawn = dict[str, Any]


@functools.cache
def read_ranges() -> dict[str, Any]:
    """Read all ranges.

    Returns
    -------
    dict
        Tables ``case``, ``noise``, ``friction`` and ``effects`` of ``ranges.toml``.
    """
    return tomllib.loads((Path(__file__).parent / "ranges.toml").read_text(encoding="utf-8"))


def draw(range_: Mapping[str, Any], rng: np.random.Generator) -> Any:
    """Draw from one range.

    Parameters
    ----------
    range_
        ``uniform`` or ``log`` with low and high end, or ``choice`` with values.
    rng
        Random generator, which moves on.

    Returns
    -------
    float or str
        What was drawn; a number in the unit of the range.

    Examples
    --------
    >>> draw({"choice": ["static"]}, np.random.default_rng(0))
    'static'
    """
    ((way, ends),) = range_.items()
    if way == "choice":
        return ends[int(rng.integers(len(ends)))]
    if way == "log":
        return float(np.exp(rng.uniform(*np.log(ends))))
    return float(rng.uniform(*ends))


def draw_all(ranges: Mapping[str, Mapping[str, Any]], rng: np.random.Generator) -> Drawn:
    """Draw from each of some ranges.

    Parameters
    ----------
    ranges
        Ranges by name.
    rng
        Random generator, which moves on.

    Returns
    -------
    dict
        What was drawn, by name.
    """
    return {name: draw(range_, rng) for name, range_ in ranges.items()}


def draw_friction(joint: Mapping[str, float], rng: np.random.Generator) -> Drawn:
    """Draw the friction law of a joint and what LuGre friction has no parameter for.

    Parameters
    ----------
    joint
        Parameters of the joint; ``Fc`` and ``Fs`` [N m] are used.
    rng
        Random generator, which moves on.

    Returns
    -------
    dict
        ``law``, one of `physics.LAWS`, ``Fs``, and parameters of ``stranger.c`` by name, SI units.
    """
    ranges = read_ranges()["friction"]
    law = draw(ranges["law"], rng)
    stiction = joint["Fc"] + draw(ranges["stiction"], rng) * (joint["Fs"] - joint["Fc"])
    drawn = draw_all(ranges[law], rng)
    if law == "generalised_maxwell":
        drawn["attraction"] = drawn.pop("attraction_per_s") * joint["Fc"]
    if law == "static":
        drawn["creep"] = drawn.pop("creep_rad_s")
    return {"law": law, "Fs": stiction, **drawn}
