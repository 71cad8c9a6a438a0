"""Summaries of posteriors that are known because their chains are drawn here."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.model.equations.quantity import Quantity
from haptid.uq.result.sampler_state import state_of, tell_state
from haptid.uq.result.summary import ParameterSummary, summarise

FLAT = Quantity(
    id="Ks", unit="N m/rad", description="stiffness", initial=0.02, lower=0.0, upper=0.15, structured="spring.Ks"
)
RNG = np.random.default_rng(3)


class OneCoordinate:
    """Coordinates of one parameter that moves in its logarithm under a prior that is flat in its value."""

    names, units, hyper = ("Ks",), ("N m/rad",), ()

    def __init__(self, quantity: Quantity) -> None:
        self.free = (quantity,)
        self.floor = max(quantity.lower, 1e-9)

    def bounds(self):
        return np.log([self.floor]), np.log([self.free[0].upper])

    def values(self, eta):
        return np.exp(eta)

    def draw(self, rng, size):
        return np.log(rng.uniform(self.floor, self.free[0].upper, (size, 1)))


def summary_of(values: np.ndarray, quantity: Quantity = FLAT) -> ParameterSummary:
    chain = np.log(np.clip(values, 1e-9, None)).reshape(4, -1, 5, 1)
    (found,) = summarise(OneCoordinate(quantity), SimpleNamespace(chain=chain), np.random.default_rng(0))
    return found


def test_what_piles_up_at_zero_has_an_upper_limit_however_wide_its_logarithm():
    found = summary_of(RNG.exponential(3.6e-6, 4000))
    assert np.log(RNG.exponential(3.6e-6, 4000)).std() > np.log(RNG.uniform(0, 0.15, 4000)).std()
    assert found.contraction < 1e-3
    assert found.limit.side == "below"
    assert found.limit.value == pytest.approx(1.08e-5, rel=0.1)
    assert found.verdict.startswith("Ks cannot be told from 0: with 95 % it is below 1")
    assert found.verdict.endswith("e-05 N m/rad.")


def test_what_piles_up_at_another_bound_names_the_bound():
    found = summary_of(0.15 - RNG.exponential(1e-3, 4000))
    assert found.limit.side == "above"
    assert found.verdict == "Ks lies at its upper bound of 0.15 N m/rad: with 95 % it is above 0.15 N m/rad."
    raised = summary_of(0.01 + RNG.exponential(1e-3, 4000), replace(FLAT, lower=0.01, initial=0.02))
    assert raised.verdict.startswith("Ks lies at its lower bound of 0.01 N m/rad: with 95 % it is below 0.013")


def test_what_the_data_do_not_touch_is_as_wide_as_its_prior():
    found = summary_of(RNG.uniform(0.0, 0.15, 4000))
    assert found.verdict == "Ks is set by its prior: its interval is as wide as without the data."
    hardly = summary_of(RNG.uniform(0.005, 0.14, 4000))
    assert 0.5 < hardly.contraction < 0.95
    assert hardly.verdict.startswith("Ks is set by its prior: its interval is ")
    assert hardly.verdict.endswith(" % as wide as without the data.")


def test_what_the_data_determine_has_its_width():
    found = summary_of(0.05 + 0.0005 * RNG.standard_normal(4000))
    assert found.limit is None
    assert found.verdict.startswith("Ks is known to ±2 % (95 %)") or found.verdict.startswith("Ks is known to ±1.9")


def test_what_the_data_hardly_determine_has_its_interval():
    """An interval from a third to the threefold was "known to ±184 %"."""
    found = summary_of(0.03 * np.exp(0.5 * RNG.standard_normal(4000)), replace(FLAT, lower=1e-6))
    ends = found.intervals[0.95]
    assert ends == pytest.approx(0.03 * np.exp(0.5 * np.array([-1.96, 1.96])), rel=0.15)
    told = " to ".join(f"{end:.3g}" for end in ends)
    assert found.verdict == f"Ks is hardly known: its 95 % interval is {told} N m/rad."


def short(*, reached: bool) -> SimpleNamespace:
    return SimpleNamespace(reached=reached)


def test_short_chains_of_one_mode_are_too_short_and_do_not_disagree():
    assert state_of(short(reached=False), 1.029, 1) == "too_short"
    assert state_of(short(reached=False), 1.001, 1) == "short"
    assert state_of(short(reached=False), 1.029, 2) == "ensembles_disagree"
    assert state_of(short(reached=True), 1.029, 1) == "ensembles_disagree"
    assert state_of(short(reached=True), 1.001, 1) == "sound"
    assert tell_state("sound") == []
    (line,) = tell_state("too_short")
    assert line.startswith("  too short: ")
    assert "do not use the intervals yet" in line
