"""First guesses of a link's inertial parameters, completed by stated uncertainty and checked to be physical."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from haptid.model.device.device import STANDARD, Guess, Inertial
from haptid.support.errors import InputError

LARGEST = 1e12
"""No mass, length or inertia of a link is larger."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Uncertainty:
    """Standard deviations of guesses that are given as plain numbers.

    mass, inertia, rotor: relative; centroid: [m]. A product of inertia has `inertia` times the smallest principal
    entry.
    """

    mass: float = 0.3
    centroid: float = 0.01
    inertia: float = 0.3
    rotor: float = 0.3

    def stds(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the standard deviation of each of the ten standard parameters, from their first guesses."""
        products = self.inertia * min(values["I11"], values["I22"], values["I33"])
        return {
            "m": self.mass * values["m"],
            **dict.fromkeys("xyz", self.centroid),
            **{key: self.inertia * values[key] for key in ("I11", "I22", "I33")},
            **dict.fromkeys(("I12", "I13", "I23"), products),
        }

    def rotor_guess(self, guess: Guess) -> Guess:
        """Complete a rotor's guess."""
        return guess if guess.fixed else widened(guess, self.rotor * guess.initial, positive=True)


def widened(guess: Guess, std: float, *, positive: bool) -> Guess:
    """Give a bare guess a standard deviation and bounds: ±4 std, for positive quantities from 5 % up."""
    if guess.fixed or guess.std is not None:
        return guess
    lower, upper = guess.initial - 4 * std, guess.initial + 4 * std
    if positive:
        lower = max(lower, 0.05 * guess.initial)
    return replace(guess, std=std or None, lower=max(lower, guess.lower), upper=min(upper, guess.upper))


def inertial(
    entry: Mapping[str, Any], where: str, uncertainty: Uncertainty, guess: Callable[[Any, str], Guess]
) -> Inertial | None:
    """Return the guesses of one ``[[links]]`` entry, or None where it has no mass."""
    if "mass" not in entry:
        return None
    raw = {"m": guess(entry["mass"], f"{where}.mass")}
    raw |= {
        key: guess(value, f"{where}.centroid[{i}]")
        for i, (key, value) in enumerate(zip("xyz", entry["centroid"], strict=True))
    }
    raw |= {key: guess(entry["inertia"].get(key, 0.0), f"{where}.inertia.{key}") for key in STANDARD[4:]}
    values = {key: one.initial for key, one in raw.items()}
    check_physical(values, where)
    stds = uncertainty.stds(values)
    positive = ("m", "I11", "I22", "I33")
    return Inertial(guesses=tuple(widened(raw[key], stds[key], positive=key in positive) for key in STANDARD))


def check_physical(values: Mapping[str, float], where: str) -> None:
    """Refuse a mass or an inertia that no distribution of mass can have (Traversaro et al. 2016)."""
    absurd = next((key for key, value in values.items() if not abs(value) < LARGEST), None)
    if absurd is not None:
        expected = f"numbers below {LARGEST:g} in SI units"
        place = f"{where}: {absurd}"
        raise InputError(place, expected=expected, got=str(values[absurd]))
    if not values["m"] > 0:
        raise InputError(
            where=f"{where}.mass", expected="a positive mass (leave it out for a massless link)", got=str(values["m"])
        )
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
        raise InputError(
            where=f"{where}.inertia", expected=expected, got=f"principal moments {np.linalg.eigvalsh(tensor).tolist()}"
        )
