"""Blind cases: what is asked for is what is hidden, at the size that the label says, and the label lies apart."""

import json
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.effects import LISTED, UNLISTED, Scales, Shape, resolve
from haptid.virtual_device.machine.joint import integrate
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.recording.inputs import rich
from haptid.virtual_device.recording.sensor import Sensor
from studies.hidden.further_run import add_run
from studies.hidden.plan import NAMED, plan
from studies.hidden.run import _size, make_cases
from studies.hidden.sizing import Reach, positions, reach


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[dict[str, Any]]]:
    out = tmp_path_factory.mktemp("blind")
    return out, make_cases(out, 3, 11, kinds=("single",), sizes=("threshold", "nominal"), inputs="rich")


def test_the_catalogue_of_disturbances_is_that_of_the_users() -> None:
    assert len(LISTED) == 34
    assert not set(LISTED) & set(UNLISTED)


def test_a_plan_goes_through_every_effect_and_size_before_one_comes_again() -> None:
    count = len(NAMED) * 3
    cases = plan(count, np.random.default_rng(0), ("single",), ("nominal", "small", "threshold"), "mixed")
    assert Counter((case.effects[0], case.size) for case in cases) == {
        (name, size): 1 for name in NAMED for size in ("nominal", "small", "threshold")
    }
    assert {case.joint for case in cases} == set(range(6))
    assert {case.device for case in cases} == {"single_joint", "freedom6s"}


def test_kinds_hide_what_their_name_says() -> None:
    cases = plan(
        63, np.random.default_rng(1), ("none", "pair", "scatter", "scatter_with", "unlisted"), ("small",), "rich"
    )
    assert all(case.effects == () for case in cases if case.kind == "none")
    assert all(len(set(case.effects)) == 2 for case in cases if case.kind == "pair")
    assert all(case.effects == ("amplitude_scatter",) for case in cases if case.kind == "scatter")
    assert all(case.effects[1] == "amplitude_scatter" for case in cases if case.kind == "scatter_with")
    assert all(case.effects[0] in UNLISTED for case in cases if case.kind == "unlisted")
    assert any(case.coloured > 0 for case in cases)


@pytest.mark.long
def test_labels_lie_apart_and_describe_what_was_hidden(made: tuple[Path, list[dict[str, Any]]]) -> None:
    out, _ = made
    stored = json.loads((out / "labels.json").read_text())["labels"]
    assert [label["case"] for label in stored] == sorted(path.name for path in (out / "cases").iterdir())
    for label in stored:
        folder = out / "cases" / label["case"]
        text = (folder / "campaign.toml").read_text()
        assert not any(name in text for name in (*LISTED, *UNLISTED))
        content = tomllib.loads(text)
        assert content["campaign"]["measured"] is False
        assert sum(run["use"] == "validate" for run in content["runs"]) >= 2
        assert list(label["hidden"]) == label["effects"]


@pytest.mark.long
def test_a_table_holds_the_labelled_disturbance_and_only_noise_besides(
    made: tuple[Path, list[dict[str, Any]]],
) -> None:
    out, labels = made
    for label in labels:
        joint = label["joint"]
        paths = sorted((out / "cases" / str(label["case"])).glob("*.gz"))
        table = pd.read_csv(paths[0])
        parameters = dict(label["base"])
        for values in label["hidden"].values():
            parameters |= values
        t, torque, read = (table[name].to_numpy() for name in ("time_s", f"torque_{joint}_Nm", f"position_{joint}_rad"))
        reading = integrate(parameters, t, torque, start=(read[:1].mean(), 0.0))[2]
        late = t > 10.0  # the start is known to the noise only, and forgotten by then
        std = np.hypot(label["noise"], 1.5e-4 / np.sqrt(12))
        assert np.std((read - reading)[late]) < 2.0 * std


@pytest.mark.long
def test_sizes_mean_what_they_say(made: tuple[Path, list[dict[str, Any]]]) -> None:
    for label in made[1]:
        (left,), (share,) = label["left_over_noise"].values(), label["share_of_motion"].values()
        if label["size"] == "threshold":
            assert 0.05 < left < 0.6
        else:
            assert left > 1.0 or share > 0.005


@pytest.mark.long
def test_what_a_refit_reaches_leaves_nothing_and_cogging_leaves_most() -> None:
    joint = Arm(read_truth()).locked_joint(4, np.zeros(6))
    base = reach(joint, rich(4)[:4])
    spring = positions(joint | {"Ks": joint["Ks"] * 1.001}, base.runs) - base.motion
    assert base.left(spring) < 0.02 * np.sqrt(np.mean(spring**2))
    stiffer = positions(joint | {"Ks": 2 * joint["Ks"], "sigma2": 2 * joint["sigma2"]}, base.runs) - base.motion
    assert base.left(stiffer) < 1e-3 * np.sqrt(np.mean(stiffer**2))
    cogging = base.effect({"cogging": 2e-5, "cogging_number": 12.0})
    assert base.left(cogging) > 0.4 * np.sqrt(np.mean(cogging**2))


@pytest.mark.long
def test_what_the_joint_itself_takes_up_is_hidden_where_it_shows(tmp_path: Path) -> None:
    """An eccentric encoder beside free gravity would have to be larger than the motion."""
    chosen = {"kinds": ("single",), "sizes": ("nominal",), "inputs": "table3", "effects": ("encoder_eccentricity",)}
    for label in make_cases(tmp_path, 2, 3, **chosen):
        assert label["share_of_motion"]["encoder_eccentricity"] <= 0.33
        assert label["left_over_noise"]["encoder_eccentricity"] >= 0.1


def test_what_a_refit_leaves_nothing_of_is_no_case(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it leaves need not grow with the size: a small bent spring left 0.05 of the noise, its threshold 0.2."""
    case = plan(1, np.random.default_rng(0), ("single",), ("small",), "table3", ("asymmetric_spring",))[0]
    base = reach(Arm(read_truth()).locked_joint(4, np.zeros(6)), rich(4)[:1])
    std = Sensor(noise=case.noise).std
    for name in ("threshold_size", "marked_size"):
        monkeypatch.setattr(f"studies.hidden.run.{name}", lambda *_: 0.01)
    rng = np.random.default_rng(0)
    monkeypatch.setattr(Reach, "left", lambda *_: 0.2 * std)
    assert _size(case, base, "asymmetric_spring", Shape.draw(rng), rng)[1] == 0.2 * std
    monkeypatch.setattr(Reach, "left", lambda *_: 0.05 * std)
    with pytest.raises(NumericalError, match="take up all"):
        _size(case, base, "asymmetric_spring", Shape.draw(rng), rng)


def test_cases_repeat_and_workers_do_not_matter(tmp_path: Path) -> None:
    first, second = tmp_path / "a", tmp_path / "b"
    make_cases(first, 2, 5, kinds=("none",), inputs="table3")
    make_cases(second, 2, 5, kinds=("none",), inputs="table3", workers=2)
    files = [{path.relative_to(out): path.read_bytes() for path in out.rglob("*.*")} for out in (first, second)]
    assert files[0] == files[1]


def test_two_disturbances_of_one_tendon_are_not_hidden_together() -> None:
    pairs = len(NAMED) * (len(NAMED) - 1) // 2 - 1
    drawn = plan(pairs, np.random.default_rng(0), ["pair"], ["nominal"], "rich")
    assert len({case.effects for case in drawn}) == pairs
    assert ("tendon_elasticity", "tendon_slack") not in {tuple(sorted(case.effects)) for case in drawn}
    scales = Scales(torque=0.01, amplitude=0.3, speed=1.0, rest=0.0, inertia=1e-4, Ks=0.02, sigma2=1e-3)
    with pytest.raises(InputError, match="tendon_slack, which sets inertia as another one does"):
        resolve({"tendon_elasticity": 1.0, "tendon_slack": 1.0}, scales)


def test_unknown_kinds_are_refused() -> None:
    with pytest.raises(InputError, match="--kinds"):
        plan(1, np.random.default_rng(0), ("nothing",), ("nominal",), "rich")


def test_only_the_effects_that_are_asked_for_are_hidden() -> None:
    cases = plan(20, np.random.default_rng(0), ("single", "pair"), ("small",), "rich", ("cogging", "time_delay"))
    assert {name for case in cases for name in case.effects} == {"cogging", "time_delay"}
    with pytest.raises(InputError, match="--effects"):
        plan(1, np.random.default_rng(0), ("single",), ("small",), "rich", ("cogs",))
    with pytest.raises(InputError, match="kind 'unlisted' hides"):
        plan(1, np.random.default_rng(0), ("unlisted",), ("small",), "rich", ("cogging",))


@pytest.mark.long
def test_a_run_asked_for_shows_the_same_joint(made: tuple[Path, list[dict[str, Any]]], tmp_path: Path) -> None:
    out, labels = made
    label = labels[0]
    case, joint = str(label["case"]), label["joint"]
    request = {"amplitude": 0.004, "frequency": 5.0, "offset": 0.001, "duration": 12.0}
    add_run(out, case, request, tmp_path / "copy")
    content = tomllib.loads((tmp_path / "copy" / "campaign.toml").read_text())
    before = tomllib.loads((out / "cases" / case / "campaign.toml").read_text())
    assert content["runs"][:-1] == before["runs"]
    assert content["runs"][-1]["use"] == "fit"
    table = pd.read_csv(tmp_path / "copy" / content["runs"][-1]["file"])
    t, torque, read = (table[name].to_numpy() for name in ("time_s", f"torque_{joint}_Nm", f"position_{joint}_rad"))
    np.testing.assert_allclose(torque, 0.001 + 0.004 * np.cos(5.0 * t), atol=1e-8)
    parameters = dict(label["base"]) | {k: v for values in label["hidden"].values() for k, v in values.items()}
    reading = integrate(parameters, t, torque, start=(read[:1].mean(), 0.0))[2]
    assert np.std((read - reading)[t > 8.0]) < 2.0 * np.hypot(label["noise"], 1.5e-4 / np.sqrt(12))


@pytest.mark.long
@pytest.mark.parametrize(
    ("case", "request_", "told"),
    [
        ("case_0099", {"frequency": 1.0, "duration": 5.0}, "--extra"),
        ("case_0000", {"frequency": 0.0, "duration": 5.0}, "frequency"),
    ],
)
def test_a_run_that_cannot_be_made_is_refused(
    made: tuple[Path, list[dict[str, Any]]], tmp_path: Path, case: str, request_: dict[str, float], told: str
) -> None:
    with pytest.raises(InputError, match=told):
        add_run(made[0], case, {"amplitude": 0.01, "offset": 0.0} | request_, tmp_path)
