"""Cases of the stranger: what the label says is what is hidden, and a name is right if it is the kind."""

import json
import tomllib
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from haptid.model.effects.registry import catalogue
from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.stranger.effects import FORMULAS
from studies.blind.stranger import score_stranger
from studies.blind.stranger_page import count_kinds, describe_cases
from studies.hidden.kinds import KINDS, LAW
from studies.hidden.stranger import make_stranger_cases
from studies.hidden.stranger_plan import plan_stranger
from studies.hidden.stranger_sizing import TOLERANCE, Bench, draw_size


def label(*effects: str, outside: tuple[str, ...] = (), law: str = "bristle") -> dict[str, Any]:
    kind = ("none", "single", "several")[min(len(effects), 2)]
    return {
        "case": "case_0000", "kind": kind, "effects": list(effects), "outside": list(outside), "size": "large",
        "joint": 4, "friction": {"law": law},
        "device": "single_joint", "inputs": "rich", "coloured": 0.0, "base": {"inertia": 1e-4}, "hidden": {},
    }  # fmt: skip


def found(verdict: str, *names: str, rivals: tuple[str, ...] = ()) -> dict[str, Any]:
    return {
        "verdict": verdict, "effects": [{"id": name, "parameters": {}} for name in names], "gap": {}, "wall_s": 1.0,
        "simulations": 1, "alternatives": [{"ids": [name]} for name in rivals], "next_experiment": None,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("hidden", "finding", "result"),
    [
        (label("delay_and_lag"), found("named", "time_delay"), "named"),
        (label("delay_and_lag"), found("named", "amplifier_lag"), "named"),
        (label("delay_and_lag"), found("named", "cogging"), "wrong_name"),
        (label("gear_wave", "power_drag"), found("named", "quadratic_drag", "cogging"), "named"),
        (label("gear_wave", "power_drag"), found("named", "cogging"), "named_in_part"),
        (label("gear_wave", outside=(LAW,)), found("named", "cogging"), "named"),
        (label("gear_wave", outside=(LAW,)), found("unlisted"), "unnamed"),
        (label("gear_wave"), found("ambiguous", "torque_ripple", rivals=("cogging",)), "among_alternatives"),
        (label("gear_wave"), found("nothing_missing"), "missed"),
        (label("gear_wave"), None, "failed"),
        (label(), found("nothing_missing"), "nothing_rightly"),
        (label(), found("unlisted"), "false_alarm"),
        (label("gear_wave", outside=(LAW,)), found("named", "cogging", "stribeck_shape"), "named"),
        (label("gear_wave", outside=(LAW,)), found("named", "cogging", "quadratic_drag"), "named_in_part"),
        (label("gear_wave"), found("named", "stribeck_shape"), "missed"),
        (label(), found("named", "stribeck_shape"), "nothing_rightly"),
        (label(), found("named", LAW, "cogging"), "false_alarm"),
        (label(law="dahl"), found("named", "stribeck_shape"), "false_alarm"),
        (label(outside=(LAW,)), found("unlisted"), "flagged"),
        (label(outside=(LAW,)), found("named", "stribeck_shape"), "named"),
        (label(outside=(LAW,), law="dahl"), found("named", "stribeck_shape"), "wrong_name"),
        (label(outside=(LAW,)), found("ambiguous", "stribeck_shape", rivals=("friction_lag",)), "flagged"),
        (label(outside=(LAW,)), found("named", "friction_lag"), "wrong_name"),
        (label(outside=(LAW,)), found("nothing_missing"), "missed"),
    ],
)
def test_a_name_is_right_if_it_is_the_kind(hidden: dict[str, Any], finding: dict[str, Any] | None, result: str) -> None:
    assert score_stranger(hidden, finding, reason="" if finding else "not finished").result == result


def test_every_kind_has_names_of_the_catalogue() -> None:
    assert set(KINDS) == set(FORMULAS)
    assert {id for ids in KINDS.values() for id in ids} <= {entry.id for entry in catalogue().values()}
    assert len({ids[0] for ids in KINDS.values()}) >= 15


def test_a_plan_repeats_and_hides_one_to_four_kinds() -> None:
    cases = plan_stranger(200, np.random.default_rng(1))
    assert cases == plan_stranger(200, np.random.default_rng(1))
    assert {len(case.hides) for case in cases} == {0, 1, 2, 3, 4}
    assert {name for case in cases for name in case.hides} == set(FORMULAS)
    for case in cases:
        names = [id for name in case.hides for id in KINDS[name]]
        assert len(names) == len(set(names))
    with pytest.raises(InputError, match="--effects"):
        plan_stranger(1, np.random.default_rng(0), effects=("cogging",))


@pytest.mark.long
def test_a_case_repeats_and_its_label_lies_apart(tmp_path: Path) -> None:
    asked = {"kinds": ("single",), "inputs": "table3", "effects": ("gear_wave",)}
    first, second = (make_stranger_cases(tmp_path / name, 1, 5, **asked)[0] for name in ("a", "b"))
    files = [{p.relative_to(out): p.read_bytes() for p in out.rglob("*.*")} for out in (tmp_path / "a", tmp_path / "b")]
    assert files[0] == files[1]
    assert first == second == json.loads((tmp_path / "a" / "labels.json").read_text())["labels"][0]
    text = (tmp_path / "a" / "cases" / "case_0000" / "campaign.toml").read_text()
    assert "gear" not in text
    assert first["friction"]["law"] not in text
    assert first["left_over_noise"]["gear_wave"] > 0.1
    assert first["share_of_motion"]["gear_wave"] < 0.7
    assert ("sensor" in tomllib.loads(text)) == (first["stated"] is not None)


class Slope:
    """A bench on which a disturbance leaves a power of its size, and is a tenth of the motion at a size of 1."""

    std = 1.0

    def __init__(self, power: float) -> None:
        self.base, self.power = self, power

    def change(self, values: dict[str, float]) -> float:
        return values["size"]

    def left_at_first(self, change: float) -> float:
        return 10.0 * change**self.power

    def share(self, change: Any) -> float:
        return 0.1 * (change["size"] if isinstance(change, dict) else change)

    def left(self, values: dict[str, float]) -> float:
        return self.left_at_first(values["size"])


@pytest.mark.parametrize("power", [1.0, 2.5, 9.0])
def test_sizes_lie_between_the_threshold_and_the_largest_share_or_are_refused(power: float) -> None:
    bench, rng = Slope(power), np.random.default_rng(0)
    kept = 0
    for _ in range(50):
        try:
            size = draw_size(cast("Bench", bench), lambda k: {"size": k}, 0.3, rng)
        except NumericalError:
            continue
        kept += 1
        assert bench.left_at_first(size) >= 0.2 / TOLERANCE
        assert bench.share(size) <= 0.3 * TOLERANCE
    assert kept == 50 or power > 2.0


def test_the_page_says_what_was_hidden_how_large_and_in_which_noise() -> None:
    hidden = {
        **label("gear_wave"), "hidden": {"gear_wave": {}}, "left_over_noise": {"gear_wave": 3.21},
        "share_of_motion": {"gear_wave": 0.04}, "friction": {"law": "dahl"}, "friction_law_left_over_noise": 0.2,
        "recorder": {"coloured": 1e-4, "jitter": 0.0, "smoothing": 5}, "stated": None,
    }  # fmt: skip
    case = score_stranger(hidden, found("named", "cogging")).as_json()
    (row,) = describe_cases([case], [hidden])[1]
    told = ("gear_wave 3.2, 4 %", "dahl, leaves 0.2", "coloured, smoothed, not stated", "named cogging", "right")
    assert row == ("case_0000", *told)
    assert count_kinds([case], [hidden])[1] == [("gear_wave", "cogging", "1", "1", "named")]
