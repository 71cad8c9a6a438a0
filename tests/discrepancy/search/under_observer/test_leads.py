"""Large effects that are chosen under the observer, and names that stand though something is left."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.search.nominal_model import fit_nominal_model, score_catalogue, under_own_noise
from haptid.discrepancy.search.search import search
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.search.under_observer import laws, leads
from haptid.discrepancy.search.under_observer.laws import Led, lead_on
from haptid.discrepancy.search.under_observer.leads import (
    Lead,
    at_step_under_observer,
    begin_under_observer,
    extend_lead,
    follow_leads,
)
from haptid.discrepancy.study.simulators import Factory
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.verdict.verdict import judge
from haptid.model.effects.registry import catalogue
from haptid.support.listener import ignore_progress
from tests.discrepancy.finding.test_finding import study_with

KEYS = ("amplifier_dead_band:jump", "gain_drift", "asymmetric_viscous", "cubic_spring", "torque_ripple")
HIDDEN = {"amplifier_dead_band": {"dead_band": 0.0012}, "asymmetric_viscous": {"viscous_asymmetry": 0.6}}


def tools(study: Study) -> tuple[Searcher, Solution]:
    study, base = fit_nominal_model(study, seed=0, starts=2, tell=ignore_progress)
    white, plain = under_own_noise(study, base)
    listed, found, first = score_catalogue(study, plain, ignore_progress)
    return Searcher(study, listed, found, first.tests, ignore_progress), white


def searched(study: Study) -> Led:
    s, white = tools(study)
    return lead_on(s, begin_under_observer(s, white), white)


@pytest.mark.long
def test_two_large_effects_are_chosen_one_by_one(tmp_path: Path):
    led = searched(study_with(tmp_path / "c", HIDDEN, {key: catalogue()[key] for key in KEYS}))
    assert led.law is None
    best = led.leads[0]
    assert {e.id for e in best.effects} == set(HIDDEN)
    rows = led.at.study.rows
    # The corner of the dead band is still rounded.
    assert best.excess(rows) < 0.02 * led.at.excess


@pytest.mark.long
def test_a_name_stands_where_no_other_effect_comes_near_though_something_is_left(tmp_path: Path):
    # The smaller effect is not in the catalogue, and no other effect acts as it does.
    listed = {key: catalogue()[key] for key in ("amplifier_dead_band:jump", "torque_ripple", "cubic_spring")}
    hidden = {"amplifier_dead_band": {"dead_band": 0.002}, "asymmetric_viscous": {"viscous_asymmetry": 0.1}}
    study = study_with(tmp_path / "c", hidden, listed)
    found = search(study, starts=2)
    assert not found.best.adequate
    assert found.standing == ("amplifier_dead_band:jump",)
    judgement = judge(study, found)
    assert judgement.verdict == "partly_named"
    # What the name leaves is shown without a name, where it lives.
    assert judgement.shape is not None
    assert judgement.shape.beside == found.standing
    assert "velocity_rad_s" in judgement.shape.variables
    assert judgement.shape.closed > 0.5


def score_lowest(monkeypatch: pytest.MonkeyPatch, key: str, share: float) -> None:
    """Let an effect have a share of the lowest score under the observer."""
    scores = leads.scan

    def scan(*args: Any, **more: Any) -> Any:
        made = scores(*args, **more)
        least = share * min(score.T for score in made.scores)
        return replace(made, scores=tuple(replace(x, T=least if x.key == key else x.T) for x in made.scores))

    monkeypatch.setattr(leads, "scan", scan)


def test_an_effect_of_a_low_score_is_found_by_a_try(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    hidden = {"amplifier_dead_band": HIDDEN["amplifier_dead_band"]}
    s, white = tools(study_with(tmp_path / "c", hidden, {key: catalogue()[key] for key in KEYS}))
    at = begin_under_observer(s, white)
    low = "amplifier_dead_band:jump"
    score_lowest(monkeypatch, low, share=0.5)
    limits = replace(THRESHOLDS.search, least_score_share_under_observer=0.0)
    monkeypatch.setattr(leads, "THRESHOLDS", replace(THRESHOLDS, search=limits))
    assert extend_lead(s, at, at.start)[0].effects[-1].key == low


def test_an_effect_that_the_nominal_model_hides_is_fitted_whatever_its_score(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """A cubic spring beside rigid friction, which gravity and spring follow but for a hundredth, was passed over."""
    hidden = {"amplifier_dead_band": HIDDEN["amplifier_dead_band"]}
    s, white = tools(study_with(tmp_path / "c", hidden, {key: catalogue()[key] for key in KEYS}))
    at = begin_under_observer(s, white)
    low = "amplifier_dead_band:jump"
    score_lowest(monkeypatch, low, share=0.0)
    assert low not in {lead.effects[-1].key for lead in extend_lead(s, replace(at, hidden=frozenset()), at.start)}
    assert extend_lead(s, replace(at, hidden=frozenset({low})), at.start)[0].effects[-1].key == low


def test_a_step_under_the_observer_is_halved_until_its_error_is_no_share_of_what_is_missing(
    monkeypatch: pytest.MonkeyPatch,
):
    class Problem:
        def __init__(self, step: float) -> None:
            self.step = step

        def blocks(self, x: Any, gain: float, *, jacobian: bool) -> Any:  # noqa: ARG002 (as `Problem.blocks`)
            return SimpleNamespace(residual=np.full(ROWS, 1e3 * self.step))

    def begin(study: Any, effects: Any, values: Any) -> Any:  # noqa: ARG001 (as `start_holding_last_shape`)
        return SimpleNamespace(problem=Problem(study.factory.step))

    monkeypatch.setattr(leads, "start_holding_last_shape", begin)
    first = THRESHOLDS.study.coarse_step_s
    share = THRESHOLDS.search.least_share_of_all_under_observer

    def chosen(steps: int) -> Factory:
        """Choose a step where halving it so many times makes its error invisible: ‖e‖² = n·(1e3·h/2)²."""
        excess = 1.01 * ROWS * (1e3 * first / 2**steps / 2) ** 2 / share
        fit: Any = SimpleNamespace(values={}, gain=6.0, reached=SimpleNamespace(x=None))
        at: Any = SimpleNamespace(start=Lead(effects=(), fit=fit), study=_Stepped(factory=Factory()), excess=excess)
        return at_step_under_observer(at).factory

    assert chosen(0) == Factory()
    assert [chosen(n).step for n in (1, 3)] == [first / 2, first / 8]
    assert chosen(3).coarse == first / 8
    assert chosen(20).step == first / 2**THRESHOLDS.detect.most_step_halvings


@dataclass(frozen=True)
class _Stepped:
    """A study of which only the inner step is known."""

    factory: Factory


class _Left:
    """A model under the observer, of which only what it leaves is known."""

    def __init__(self, cost: float, *names: str) -> None:
        self.cost, self.name = cost, "+".join(names)
        self.effects = tuple(SimpleNamespace(id=name, key=name) for name in names)

    def excess(self, rows: int) -> float:
        return max(self.cost - rows, 0.0)

    def over_noise(self, rows: int) -> float:
        return float((self.cost / rows) ** 0.5)

    is_far = leads.Lead.is_far


ROWS = 100


@pytest.mark.parametrize(("left", "gains"), [(1.9, 4), (2.1, 3)])
def test_the_gain_is_lower_where_the_observer_hides_what_is_missing(
    left: float, gains: int, monkeypatch: pytest.MonkeyPatch
):
    class Fit:
        def __init__(self, level: int) -> None:
            self.level, self.gain = level, 6.0
            self.reached = SimpleNamespace(cost=left**2 * ROWS, calls=level)

        def down_to(self, level: int) -> "Fit":
            return Fit(level)

        def linearised(self, effects: tuple[()]) -> None:
            assert effects == ()

    def fit(s: Any, study: Any, effects: Any, values: Any, level: int) -> Lead:  # noqa: ARG001 (as `fit_lead`)
        return Lead(effects=effects, fit=Fit(level))  # type: ignore[arg-type] # a stub

    monkeypatch.setattr(leads, "fit_lead", fit)
    monkeypatch.setattr(leads, "signatures", lambda *_, **__: SimpleNamespace(simulations=0))
    scores = [SimpleNamespace(key=key, survives=left) for key, left in (("cubic_spring", 0.009), ("gain_drift", 0.4))]
    monkeypatch.setattr(leads, "scan", lambda *_, **__: SimpleNamespace(scores=scores))
    study = SimpleNamespace(rows=ROWS, fitted=(1, 2))
    whole = SimpleNamespace(factory=Factory())
    s: Any = SimpleNamespace(study=whole, side_by_side=lambda _: study, catalogue={}, simulations=0)
    nominal: Any = SimpleNamespace(values={})
    at = begin_under_observer(s, nominal)
    assert at.gains == gains
    assert at.hidden == {"cubic_spring"}
    assert s.simulations == 2 * (gains - 3)


TOLD: Any = SimpleNamespace(tell=ignore_progress, catalogue={})


def test_no_effect_is_added_where_less_than_the_stated_noise_is_left():
    at: Any = SimpleNamespace(study=SimpleNamespace(rows=ROWS), excess=1e4)
    before: Any = _Left(0.9 * ROWS)
    assert follow_leads(TOLD, at, before, [_Left(0.5 * ROWS, "cogging")]) == []  # type: ignore[list-item] # a stub


@pytest.mark.parametrize(("left", "asked"), [(2.0, True), (1.2, False)])
def test_no_further_effect_is_chosen_where_one_is_enough(left: float, *, asked: bool):
    at: Any = SimpleNamespace(study=SimpleNamespace(rows=ROWS), excess=1e4)
    before: Any = _Left(1e4)
    made: Any = [_Left(left**2 * ROWS, "cogging")]
    seen: list[str] = []

    def is_enough(lead: Any) -> bool:
        seen.append(lead.name)
        return True

    if asked:
        assert follow_leads(TOLD, at, before, made, is_enough) == [made]
    else:  # so near to the noise, the next round finds no share to take
        monkey = replace(THRESHOLDS.search, most_effects_under_observer=1)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(leads, "THRESHOLDS", replace(THRESHOLDS, search=monkey))
            assert follow_leads(TOLD, at, before, made, is_enough) == [made]
    assert seen == (["cogging"] if asked else [])


class _Law:
    """A friction law of which only what it leaves beside the first effect, and in the end, is known."""

    def __init__(self, beside: float, end: float) -> None:
        self.left, self.end = beside, end

    def beside(self, known: Any) -> _Left | None:
        return _Left(self.left, "friction stop") if known.name == "stop" else None

    def led(self, start: Any) -> Led:
        at: Any = None
        lead: Any = start if self.end == self.left else _Left(self.end, "stop", "more")
        return Led(law="other", at=at, leads=(lead,))


@pytest.mark.parametrize(
    ("beside", "end", "law"),
    [
        (5.0e3, 3.8e3, "other"),  # takes more than the second effect, and leaves less with fewer effects in the end
        (5.0e3, 4.1e3, None),  # leaves more in the end
        (7.0e3, 1.0e3, None),  # the second effect takes more than the law does
    ],
)
def test_a_law_competes_with_the_second_effect(
    beside: float, end: float, law: str | None, monkeypatch: pytest.MonkeyPatch
):
    names = ("stop", "cogging", "springs")
    rounds: Any = [[_Left(c, *names[: k + 1])] for k, c in enumerate((1.0e4, 6.0e3, 4.0e3))]

    def follow(*arguments: Any) -> Any:
        assert not arguments[-1](rounds[0][0])
        return rounds

    monkeypatch.setattr(laws, "follow_leads", follow)
    at: Any = SimpleNamespace(study=SimpleNamespace(rows=ROWS), start=None)
    others: Any = [_Law(beside + ROWS, end + ROWS)]
    assert laws._effects_first(TOLD, at, [], others, lambda _: False).law == law


@pytest.mark.parametrize(
    ("left", "fitted", "best"),
    [
        ({"own": 2e3, "smaller": 9e4, "known": 8e4}, ["own"], 2e3),  # next to nothing: no other start is asked
        ({"own": 7e4, "smaller": 9e4, "known": 6e4}, ["own", "smaller", "known"], 6e4),
    ],
)
def test_a_law_begins_at_its_own_guesses(
    left: dict[str, float], fitted: list[str], best: float, monkeypatch: pytest.MonkeyPatch
):
    """From a stiffness that was bent to another law's needs, a law of 1.6 times the noise was left at 8.8."""
    asked = []

    def fit(_s: Any, _study: Any, _effects: Any, values: Any, *_: Any) -> _Left:
        asked.append(values)
        return _Left(left[values] + ROWS, "")

    monkeypatch.setattr(laws, "starts_under_law", lambda *_: iter(["known", "smaller", "own"]))
    monkeypatch.setattr(laws, "fit_lead", fit)
    at: Any = SimpleNamespace(excess=1e6, gains=3)
    study: Any = SimpleNamespace(rows=ROWS)
    white: Any = None
    assert laws._best_start(TOLD, at, study, white).cost == best + ROWS
    assert asked == fitted


@pytest.mark.parametrize(("enough", "law"), [(True, None), (False, "maxwell_slip")])
def test_a_law_is_compared_where_an_effect_follows_it_under_the_observer_alone(
    enough: bool, law: str | None, monkeypatch: pytest.MonkeyPatch
):
    """A hysteresis left 1.1 times the noise under the observer, and six times of the free motion."""
    monkeypatch.setattr(laws, "follow_leads", lambda *_: [])
    assert _led(1.2, 1.01, enough=enough).law == law


@pytest.mark.parametrize(
    ("single", "law", "enough", "rival"),
    [
        (1.0, 1.02, False, "maxwell_slip"),  # both come near noise, and free motion has to tell
        (1.0, 1.02, True, None),
        (1.0, 2.0, False, None),  # the law does not
        (2.0, 1.65, False, None),  # the effect does not
    ],
)
def test_a_law_is_a_rival_where_it_comes_near_as_an_effect_does_that_is_not_enough(
    single: float, law: float, enough: bool, rival: str | None, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(laws, "follow_leads", lambda *_: [])
    monkeypatch.setattr(laws, "_effects_first", lambda _s, at, *_: Led(law=None, at=at, leads=()))
    led = _led(single, law, enough=enough)
    assert led.law is None
    assert (led.rival.law if led.rival else None) == rival


def _led(single: float, law: float, *, enough: bool) -> Led:
    """Lead on where the best effect and Maxwell-slip friction leave these mean squares under the observer."""
    best, start = _Left(single * ROWS, "cable_hysteresis"), _Left(100 * ROWS)

    def under(_s: Any, _at: Any, _white: Any, other: str) -> Any:
        left: Any = _Left(law * ROWS if other == "maxwell_slip" else 50 * ROWS)
        left.fit = SimpleNamespace(values={})
        there: Any = SimpleNamespace(start=left)
        return SimpleNamespace(law=other, at=there, led=lambda _: Led(law=other, at=there, leads=()))

    base = SimpleNamespace(friction=("lugre",))
    at: Any = SimpleNamespace(study=SimpleNamespace(rows=ROWS, alone=True, base=base), start=start)
    white: Any = None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(laws, "extend_lead", lambda *_: [best])
        patch.setattr(laws, "_under", under)
        return lead_on(TOLD, at, white, lambda _: enough)
