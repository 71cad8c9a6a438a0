"""The verdict rests on honest errors, not on the curvature that the search relies on."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.discrepancy.detect.omnibus import Omnibus
from haptid.discrepancy.search.search import search
from haptid.discrepancy.verdict.estimate import Estimate
from haptid.discrepancy.verdict.verdict import (
    Judgement,
    NamedEffect,
    _nearest,
    indistinguishable_from_zero,
    judge,
    verdict_of,
)
from haptid.model.effects.registry import catalogue
from tests.discrepancy.finding.test_finding import study_with


@pytest.mark.long
def test_a_name_whose_first_amplitude_cannot_be_told_from_nothing_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A slack of 17 ± 14 µrad had been named where an elastic tendon was missing in the catalogue."""
    study = study_with(tmp_path, {"time_delay": {"delay": 0.01}}, {"time_delay": catalogue()["time_delay"]})
    found = search(study, starts=2)
    told: list[str] = []
    named = judge(study, found, lambda title, *_, **__: told.append(title))
    assert named.verdict == "named"
    assert told == ["standard errors of the named effects"]  # a bar that stands still for half a minute says why

    rough = np.full(found.best.solution.theta.size, 0.005)
    monkeypatch.setattr("haptid.discrepancy.verdict.verdict.standard_errors", lambda _, solution, __: (solution, rough))
    refused = judge(study, found, lambda title, *_, **__: told.append(title))
    assert told[1:] == ["standard errors of the named effects", "the shape of what has no name"]
    assert refused.verdict == "unlisted"
    assert refused.sentence.endswith("It is like time_delay (torque that arrives late), but delay_time may be 0.")
    assert refused.shape is not None

    solution, least = found.best.solution, np.sqrt(np.log(study.rows))
    value = solution.values["delay_time"]
    assert indistinguishable_from_zero(solution, np.full_like(rough, 1.01 * value / least), study.rows) == (
        "delay_time",
    )
    assert indistinguishable_from_zero(solution, np.full_like(rough, 0.99 * value / least), study.rows) == ()


@pytest.mark.parametrize(
    ("gain", "passes", "verdict"),
    [
        (8.0, True, "nothing_missing"),
        (12.0, True, "unlisted"),
        (8.0, False, "unlisted"),
        (-3.0, True, "nothing_missing"),
    ],
)
def test_what_has_no_name_and_hardly_shows_on_held_out_runs_is_nothing(gain: float, passes: bool, verdict: str) -> None:
    """A friction curve that left 0.06 of the noise was an alarm with two weak names that closed nothing."""
    prediction = SimpleNamespace(score=0.0)
    plain = SimpleNamespace(passes=passes, candidate=SimpleNamespace(prediction=prediction))
    best = SimpleNamespace(
        adequate=False, solution=SimpleNamespace(keys=("friction_lag",), effects=()),
        candidate=SimpleNamespace(prediction=SimpleNamespace(score=gain / 2.0)),
    )  # fmt: skip
    study = SimpleNamespace(unseen=("a run",))
    found = SimpleNamespace(
        best=best, before=plain, beaten_by=None, study=study, law=None, rivals=(), standing=()
    )  # fmt: skip
    assert verdict_of(found) == verdict  # type: ignore[arg-type] # what the verdict reads of a search
    study.unseen = ()
    assert verdict_of(found) == "unlisted"  # type: ignore[arg-type] # without held-out runs nothing speaks against it


@pytest.mark.parametrize(("evidence", "verdict"), [(-3.7, "partly_named"), (29.0, "partly_named"), (31.0, "named")])
def test_a_scatter_that_held_out_runs_hardly_show_is_no_name_beside_a_friction_law(
    evidence: float, verdict: str
) -> None:
    """A scatter of 50 µrad with an evidence of −3.7 was named beside the friction law that was missing."""
    solution = SimpleNamespace(keys=("amplitude_scatter",), random=("amplitude_scatter",), effects=())
    found = SimpleNamespace(
        best=SimpleNamespace(adequate=True, solution=solution), beaten_by=None, law=object(), rivals=(), standing=(),
        evidence=lambda _: evidence,
    )  # fmt: skip
    assert verdict_of(found) == verdict  # type: ignore[arg-type] # what the verdict reads of a search


@pytest.mark.parametrize(("energy", "over_noise"), [(10.0, 1.0), (20.0, 1.0), (2000.0, 10.0)])
def test_what_names_leave_widens_their_errors(energy: float, over_noise: float) -> None:
    left = Omnibus(energy=energy, dof=20.0, p=0.5, parts={}, total=0.0, rows=0)
    assert left.over_noise == pytest.approx(over_noise)


@pytest.mark.parametrize(("other", "std"), [(26000.0, 642.0), (31400.0, 5121.0)])
def test_another_fit_of_the_same_model_widens_an_error(other: float, std: float) -> None:
    """A stop of 26.3 kN/m stood beside an FMU with one of 31.4."""
    stop = next(e for e in catalogue().values() if e.key == "end_stop:upper")
    stiffness = stop.parameters[0]
    named = NamedEffect(
        id=stop.id, key=stop.key, title=stop.title, formula=stop.formula, evidence=1.0,
        parameters={stiffness.id: Estimate.of_parameter(stiffness, 26279.0, 642.0)},
    )  # fmt: skip
    judgement = Judgement(
        verdict="partly_named", effects=(named,), alternatives=(), next_experiment=None, shape=None, sentence=""
    )
    refit = SimpleNamespace(values={stiffness.id: other}, equations=SimpleNamespace(parameter=lambda _: stiffness))
    estimate = judgement.beside(refit).effects[0].parameters[stiffness.id]  # type: ignore[arg-type] # all that is read
    assert estimate.value == 26279.0
    assert estimate.std == pytest.approx(std)
    assert estimate.interval[0] <= other <= estimate.interval[1]


def test_the_parameter_that_differs_most_between_runs_is_told() -> None:
    solution = SimpleNamespace(effects=(), keys=("friction_lag",))
    best = SimpleNamespace(varies=True, varying="sigma2", solution=solution)
    found = SimpleNamespace(best=best, trials=(), beaten_by=None)
    told = "with other parameters in every run (sigma2 differs most): it only stands in for it."
    assert _nearest(found, "friction_lag").endswith(told)  # type: ignore[arg-type] # what the sentence reads of a search
