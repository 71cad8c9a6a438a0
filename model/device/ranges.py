"""The possible ranges of a device's numbers, in one table: a number outside has a wrong unit and is of no use."""

from __future__ import annotations

import math
from dataclasses import dataclass

from haptid.model.device.device import Guess
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import InputError
from haptid.support.files.place import Place


@dataclass(frozen=True, slots=True)
class Range:
    """Possible range of a number.

    Parameters
    ----------
    least, most
        Smallest and largest value, in ``unit``.
    unit
        Unit, for messages.
    infinite
        Whether infinity is allowed too, as a limit that does not exist.
    """

    least: float
    most: float
    unit: str
    infinite: bool = False

    def check(self, value: float, place: Place, todo: str = "check its unit") -> float:
        """Return a number after a check of its range.

        Parameters
        ----------
        value
            Number in ``unit``.
        place
            Place of the number, for messages.
        todo
            Remedy, for messages.

        Returns
        -------
        float
            The number.

        Raises
        ------
        InputError
            Where the number lies outside the range.
        """
        endless = self.infinite and math.isinf(value) and (value > 0 or self.least < 0)
        if not endless and not self.least <= value <= self.most:
            raise InputError(str(place), expected=self.words, got=f"{value:g}", todo=todo)
        return float(value)

    def check_guess(self, guess: Guess, place: Place, todo: str = "check its unit") -> Guess:
        """Return a guess after a check of its value, bounds and standard deviation.

        Parameters
        ----------
        guess
            Guess in ``unit``.
        place
            Place of the guess, for messages.
        todo
            Remedy, for messages about the value.

        Returns
        -------
        Guess
            The guess.

        Raises
        ------
        InputError
            Where the value, a bound or the standard deviation lies outside its range.
        """
        self.check(guess.initial, place, todo)
        for name in ("lower", "upper"):
            bound = getattr(guess, name)
            if math.isfinite(bound) and abs(bound) > self.most:
                expected = f"a bound of at most {self.most:g} {self.unit}"
                raise InputError(str(place.at(name)), expected=expected, got=f"{bound:g}", todo="or leave it out")
        least = THRESHOLDS.least_std_over_value * max(abs(guess.initial), THRESHOLDS.least_std_over_value)
        if guess.std is not None and not least <= guess.std <= self.most:
            expected = f"a standard deviation from {least:.1g} to {self.most:g} {self.unit}"
            raise InputError(str(place.at("std")), expected=expected, got=f"{guess.std:g}")
        return guess

    @property
    def words(self) -> str:
        """The range in words."""
        return f"a number from {self.least:g} to {self.most:g} {self.unit}"


LENGTH = Range(-1e4, 1e4, "m")
ANGLE = Range(-1e4, 1e4, "rad")
DIRECTION = Range(-1e9, 1e9, "(the length of a direction is free)")
GRAVITY = Range(-1e3, 1e3, "m/s^2")
MASS = Range(1e-9, 1e9, "kg")
MOMENT = Range(0.0, 1e12, "kg m^2")
PRODUCT = Range(-1e12, 1e12, "kg m^2")
ROTOR = Range(1e-15, 1e6, "kg m^2")
GEAR = Range(-1e6, 1e6, "(turns of the motor for one of the joint)")
TRAVEL = Range(-1e6, 1e6, "(travel of the link for one of the joint)")
POSITION = Range(-1e6, 1e6, "rad or m", infinite=True)
TORQUE = Range(1e-9, 1e9, "N m or N", infinite=True)
FREQUENCY = Range(1e-3, 1e9, "rad/s", infinite=True)
RELATIVE = Range(1e-9, 1e3, "times the value")
CENTROID_STD = Range(1e-12, 1e4, "m")
TURNS = Range(-6, 6, "(whole turns of the link for one of the joint)")
"""Whole turns of a link per turn of its joint: the equations are polynomials of this degree in cos q and sin q."""
