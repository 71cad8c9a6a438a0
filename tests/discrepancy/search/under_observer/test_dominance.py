"""Names that stand though something is left, and the declared rivals that do nearly as well in their place."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.discrepancy.search.search import search
from haptid.discrepancy.search.under_observer import dominance
from haptid.discrepancy.verdict.verdict import judge
from haptid.model.effects.registry import catalogue
from tests.discrepancy.finding.test_finding import TRUTH, study_with


@pytest.mark.long
def test_a_one_sided_spring_is_told_beside_an_end_stop(tmp_path: Path):
    """A cable of 45 N/m from 2 mm on was named an end stop, and the spring that does as well nowhere."""
    listed = {key: catalogue()[key] for key in ("end_stop:upper", "asymmetric_spring:knee", "torque_ripple")}
    spring = {"stop_upper": TRUTH["epos"], "stop_lower": -1e9, "stop_stiffness": 0.03, "stop_damping": 0.0}
    hidden = {"end_stop": spring, "asymmetric_viscous": {"viscous_asymmetry": 0.1}}
    study = study_with(tmp_path / "c", hidden, listed)
    found = search(study, starts=2)
    assert found.standing == ("end_stop:upper",)
    assert [t.solution.keys for t in found.standing_rivals] == [("asymmetric_spring:knee",)]
    judgement = judge(study, found)
    assert judgement.verdict == "partly_named"
    told = "asymmetric_spring (spring that is stiffer on one side) does nearly as well in the place of end_stop."
    assert judgement.sentence.endswith(told)
    assert judgement.alternatives[0].solution.keys == ("asymmetric_spring:knee",)


def model(cost: float, *names: str) -> Any:
    effects = tuple(SimpleNamespace(id=name.split(":")[0], key=name) for name in names)
    return SimpleNamespace(cost=cost, effects=effects, fit=SimpleNamespace(values={}))


@pytest.mark.parametrize(
    ("left", "stands", "rivals"),
    [
        ({"spring:knee": 150.0, "delay": 900.0}, True, ["spring:knee"]),
        ({"spring:knee": 900.0, "delay": 900.0}, True, []),  # the rival leaves far more
        ({"spring:knee": 150.0, "spring": 300.0}, True, ["spring:knee"]),  # one form of it is enough
        ({"stop:lower": 150.0, "delay": 900.0}, True, []),  # another form of the effect is no rival
        ({"delay": 150.0}, False, []),
    ],
)
def test_only_declared_rivals_may_leave_nearly_as_little(
    left: dict[str, float], *, stands: bool, rivals: list[str], monkeypatch: pytest.MonkeyPatch
):
    noise, full = 50.0, model(150.0, "stop:upper")
    made = [model(cost, name) for name, cost in sorted(left.items(), key=lambda item: item[1])]
    monkeypatch.setattr(dominance, "fit_lead", lambda *_: model(1e4))
    monkeypatch.setattr(dominance, "extend_lead", lambda *_: made)
    s: Any = SimpleNamespace(rivals=lambda _: {"spring"})
    at: Any = SimpleNamespace(study=None, gains=3)
    free: Any = SimpleNamespace(stands_out=lambda *_: False)
    place = dominance._weigh_place(s, at, full, full.effects[0], noise, free)
    assert place.stands is stands
    assert [lead.effects[-1].key for lead in place.rivals] == rivals


@pytest.mark.parametrize(("criterion", "name"), [(20.0, "stop:upper"), (5.0, "spring:knee")])
def test_the_better_of_two_rivals_has_the_name(criterion: float, name: str, monkeypatch: pytest.MonkeyPatch):
    def trial(lead: Any, criterion: float) -> Any:
        solution = SimpleNamespace(effects=lead.effects, values={})
        return SimpleNamespace(candidate=SimpleNamespace(criterion=criterion), solution=solution, adequate=False)

    full, knee = model(150.0, "stop:upper"), model(150.0, "spring:knee")
    near, rival = trial(full, 10.0), trial(knee, criterion)
    place = dominance._Place(effect=full.effects[0], stands=True, rivals=(knee,))
    monkeypatch.setattr(dominance, "fit_lead", lambda *_: full)
    monkeypatch.setattr(dominance, "_weigh_place", lambda *_: place)
    monkeypatch.setattr(dominance, "_with_one_curve", lambda *_: full)
    monkeypatch.setattr(dominance, "_may_stand", lambda *_: True)
    monkeypatch.setattr(dominance, "closes_most", lambda *_: True)
    monkeypatch.setattr(dominance, "_fit_rivals", lambda *_: [rival])
    monkeypatch.setattr(dominance._FreeMotion, "leaves_far_less", lambda *_: False)
    at: Any = SimpleNamespace(study=SimpleNamespace(rows=100), start=SimpleNamespace(cost=1e4), gains=3)
    s: Any = SimpleNamespace(study=None)
    start: Any = None
    found = dominance.dominant(s, at, near, start, near)
    assert found is not None
    assert found.keys == (name,)
    assert len(found.rivals) == 1


def test_nothing_is_weighed_where_a_model_leaves_much_of_held_out_runs(monkeypatch: pytest.MonkeyPatch):
    """A model that left 89 % of them was weighed for two minutes, one effect after the other."""

    def refuse(*_: Any) -> Any:
        raise AssertionError

    monkeypatch.setattr(dominance, "fit_lead", refuse)
    study: Any = SimpleNamespace(unseen=(SimpleNamespace(sensor_std=np.array([1.0])),))
    at: Any = SimpleNamespace(study=SimpleNamespace(rows=100), start=SimpleNamespace(cost=1e4), gains=3)
    near, start = of_rms(9.0, "ripple"), of_rms(9.5)
    near.solution.values, near.adequate = {}, False
    s: Any = SimpleNamespace(study=study)
    assert dominance.dominant(s, at, near, start, near) is None


def of_rms(rms: float, *names: str) -> Any:
    solution = SimpleNamespace(effects=model(0.0, *names).effects)
    return SimpleNamespace(candidate=SimpleNamespace(prediction=SimpleNamespace(rms=(rms,))), solution=solution)


@pytest.mark.parametrize(
    ("left", "unseen", "stands"),
    [
        ({"cogging": 3.0, "stop:upper": 3.0}, True, True),
        ({"cogging": 3.0, "stop:upper": 1.5}, True, False),  # one that comes near is enough
        ({"cogging": 3.0, "stop:upper": 3.0}, False, False),  # nothing shows it where every run was fitted
    ],
)
def test_what_comes_near_under_the_observer_alone_may_be_far_in_free_motion(
    left: dict[str, float], *, unseen: bool, stands: bool, monkeypatch: pytest.MonkeyPatch
):
    """An inertia that varies closed 93 % of a gap, and cogging came near where the observer pushes it aside."""
    near = of_rms(1.2, "inertia")
    runs = (SimpleNamespace(sensor_std=np.array([1.0])),) if unseen else ()
    searcher: Any = SimpleNamespace(study=SimpleNamespace(unseen=runs))
    monkeypatch.setattr(
        dominance._FreeMotion, "fit", lambda _, effects, __: of_rms(left[effects[0].key], effects[0].key)
    )
    free = dominance._FreeMotion(searcher=searcher, near=near, start=near, at_noise=None)
    full: Any = SimpleNamespace(effects=near.solution.effects)
    assert free.stands_out(full, [model(1.0, name) for name in left]) is stands


@pytest.mark.parametrize(("whole", "closes"), [(None, False), (1.64, True), (1.0, False)])
def test_what_a_model_at_the_noise_leaves_is_the_noise_whatever_is_stated(whole: float | None, *, closes: bool):
    """A noise stated 2 % too small was a tenth of a small discrepancy, and the one name beside it was refused."""

    def trial(rms: float) -> Any:
        return SimpleNamespace(candidate=SimpleNamespace(prediction=SimpleNamespace(rms=(rms,))))

    study: Any = SimpleNamespace(unseen=(SimpleNamespace(sensor_std=np.array([1.60])),))
    model = None if whole is None else trial(whole)
    assert dominance.closes_most(study, trial(1.65), trial(1.87), model) is closes
