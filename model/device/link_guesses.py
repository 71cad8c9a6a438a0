"""First guesses of a link's inertial parameters: a ``[[links]]`` entry in, checked `Inertial` out.

Plain numbers get standard deviations and bounds from the device's stated uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from haptid.model.device.device import STANDARD, Guess, Inertial
from haptid.model.device.ranges import LENGTH, MASS, MOMENT, PRODUCT
from haptid.support.errors import InputError
from haptid.support.files.place import Place

RANGES = {
    "m": MASS,
    **dict.fromkeys("xyz", LENGTH),
    **dict.fromkeys(("I11", "I22", "I33"), MOMENT),
    **dict.fromkeys(("I12", "I13", "I23"), PRODUCT),
}
"""Possible ranges of the standard parameters of a link, by id."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Uncertainty:
    """Standard deviations of first guesses that are given as plain numbers.

    Parameters
    ----------
    mass, rotor
        Relative standard deviations of masses and rotor inertias.
    centroid
        Standard deviation of each coordinate of the centroid [m].
    inertia
        Relative standard deviation of I11, I22 and I33; a product of inertia has `inertia` times the smallest of them.
    """

    mass: float = 0.3
    centroid: float = 0.01
    inertia: float = 0.3
    rotor: float = 0.3

    def stds(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the standard deviations of the ten standard parameters of a link.

        Parameters
        ----------
        values
            First guesses by the ids of `STANDARD` [kg, m, kg m²].

        Returns
        -------
        dict of str to float
            Standard deviations by the same ids, in the same units.
        """
        products = self.inertia * min(values["I11"], values["I22"], values["I33"])
        return {
            "m": self.mass * values["m"],
            **dict.fromkeys("xyz", self.centroid),
            **{key: self.inertia * values[key] for key in ("I11", "I22", "I33")},
            **dict.fromkeys(("I12", "I13", "I23"), products),
        }

    def rotor_guess(self, guess: Guess) -> Guess:
        """Add standard deviation and bounds to a rotor's guess that has none.

        Parameters
        ----------
        guess
            Rotor inertia [kg m²].

        Returns
        -------
        Guess
            A fixed guess as it is; any other as `widen_guess` widens it, with ``rotor`` times its value as deviation.
        """
        return guess if guess.fixed else widen_guess(guess, self.rotor * guess.initial, positive=True)


def widen_guess(guess: Guess, std: float, *, positive: bool) -> Guess:
    """Add a standard deviation and bounds to a guess that has none.

    Parameters
    ----------
    guess
        First guess; a fixed guess, or one with a standard deviation, is returned unchanged.
    std
        Standard deviation, in the unit of the guess; 0 for none.
    positive
        Whether the quantity is positive: then the lower bound is at least 5 % of the first guess.

    Returns
    -------
    Guess
        The guess with bounds at ±4 std, or at its own bounds where these are narrower.
    """
    if guess.fixed or guess.std is not None:
        return guess
    lower, upper = guess.initial - 4 * std, guess.initial + 4 * std
    if positive:
        lower = max(lower, 0.05 * guess.initial)
    return replace(guess, std=std or None, lower=max(lower, guess.lower), upper=min(upper, guess.upper))


def inertial(
    entry: Mapping[str, Any], place: Place, uncertainty: Uncertainty, guess: Callable[[Any, Place], Guess]
) -> Inertial | None:
    """Read the inertial parameters of one ``[[links]]`` entry.

    Parameters
    ----------
    entry
        Table of the link.
    place
        Place of the entry, for messages.
    uncertainty
        Standard deviations of plain numbers.
    guess
        Reader of one value, (value, place) → `Guess`.

    Returns
    -------
    Inertial or None
        First guesses in the order of `STANDARD`; None where the entry has no mass.

    Raises
    ------
    InputError
        Where a number lies outside its range or the inertia is not physical.
    """
    if "mass" not in entry:
        return None
    places = {"m": place.at("mass"), **{key: place.at("centroid", i) for i, key in enumerate("xyz")}}
    places |= {key: place.at("inertia", key) for key in STANDARD[4:]}
    given = {"m": entry["mass"], **dict(zip("xyz", entry["centroid"], strict=True)), **entry["inertia"]}
    raw = {key: guess(given.get(key, 0.0), at) for key, at in places.items()}
    for key, one in raw.items():
        todo = "leave mass, centroid and inertia out where the link has no mass" if key == "m" else "check its unit"
        RANGES[key].check_guess(one, places[key], todo)
    values = {key: one.initial for key, one in raw.items()}
    check_physical(values, place.at("inertia"))
    stds = uncertainty.stds(values)
    positive = ("m", "I11", "I22", "I33")
    return Inertial(guesses=tuple(widen_guess(raw[key], stds[key], positive=key in positive) for key in STANDARD))


def check_physical(values: Mapping[str, float], place: Place) -> None:
    """Check that a distribution of mass with this inertia exists (Traversaro et al. 2016).

    Parameters
    ----------
    values
        I11, I22, I33, I12, I13, I23 about the centroid [kg m²].
    place
        Place of the inertia, for messages.

    Raises
    ------
    InputError
        Where the principal moments violate the triangle inequality.

    Notes
    -----
    The inequality holds exactly where ½·tr(I)·1 − I, the second moment of the mass, is positive semidefinite. Rounding
    is allowed for by 1e-12 of the trace.
    """
    tensor = np.array(
        [
            [values["I11"], values["I12"], values["I13"]],
            [values["I12"], values["I22"], values["I23"]],
            [values["I13"], values["I23"], values["I33"]],
        ]
    )
    smallest = np.linalg.eigvalsh(0.5 * np.trace(tensor) * np.eye(3) - tensor)[0]
    if not smallest >= -1e-12 * abs(np.trace(tensor)):
        expected = "principal moments that satisfy the triangle inequality"
        moments = ", ".join(f"{moment:g}" for moment in np.linalg.eigvalsh(tensor))
        raise InputError(str(place), expected=expected, got=f"principal moments {moments} kg m^2")
