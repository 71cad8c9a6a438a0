"""The scorer on made-up verdicts: every class of outcome, the rates, the page."""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from haptid.discrepancy.verdict.estimate import Estimate
from haptid.model.effects.registry import catalogue
from haptid.virtual_device.machine.joint import JOINT
from studies.blind.outcome import MEANING, RIGHT, Outcome, score_case
from studies.blind.page import blind_page, main
from studies.blind.score import confusion, count_settled, coverage, rate, summarise_spread, summary
from studies.blind.settle import options_of
from studies.blind.truth import FORMULAS, SAME, WAVES, true_value
from studies.hidden.run import make_cases

BASE = {"inertia": 2e-4}


def label(kind: str, *effects: str, **more: Any) -> dict[str, Any]:
    given = {"case": "case_0000", "size": "nominal", "joint": 3, "device": "single_joint", "inputs": "rich"}
    return given | {"kind": kind, "effects": list(effects), "coloured": 0.0, "base": BASE} | more


def finding(verdict: str, *ids: str, rivals: tuple[str, ...] = (), **more: Any) -> dict[str, Any]:
    effects = [{"id": id, "parameters": {}} for id in ids]
    alternatives = [{"ids": [id], "evidence": 9.0} for id in rivals]
    found = {"verdict": verdict, "effects": effects, "alternatives": alternatives, "next_experiment": None}
    return found | {"gap": {"validate": {"closed": 0.99}}, "wall_s": 10.0, "simulations": 100} | more


CASES = [
    ("single", ("cogging",), "named", ("cogging",), (), "named"),
    ("pair", ("cogging", "time_delay"), "named", ("time_delay", "cogging"), (), "named"),
    ("single", ("cogging",), "ambiguous", ("cogging",), ("torque_ripple",), "among_alternatives"),
    ("single", ("cogging",), "ambiguous", ("torque_ripple",), ("cogging",), "among_alternatives"),
    ("pair", ("cogging", "drag"), "ambiguous", ("torque_ripple", "drag"), ("cogging",), "among_alternatives"),
    ("none", (), "nothing_missing", (), (), "nothing_rightly"),
    ("unlisted", ("sticky_spot",), "unlisted", (), (), "flagged"),
    ("unlisted", ("sticky_spot",), "ambiguous", ("cogging",), ("torque_ripple",), "flagged"),
    ("pair", ("cogging", "drag"), "named", ("cogging",), (), "named_in_part"),
    ("single", ("cogging",), "named", ("cogging", "drag"), (), "named_in_part"),
    ("single", ("cogging",), "named", ("torque_ripple",), (), "wrong_name"),
    ("unlisted", ("sticky_spot",), "named", ("cogging",), (), "wrong_name"),
    ("single", ("cogging",), "ambiguous", ("drag",), ("time_delay",), "wrong_alternatives"),
    ("single", ("cogging",), "nothing_missing", (), (), "missed"),
    ("unlisted", ("sticky_spot",), "nothing_missing", (), (), "missed"),
    ("single", ("cogging",), "unlisted", (), (), "unnamed"),
    ("none", (), "named", ("cogging",), (), "false_alarm"),
    ("none", (), "unlisted", (), (), "false_alarm"),
    ("none", (), "ambiguous", ("cogging",), ("drag",), "false_alarm"),
]


@pytest.mark.parametrize(("kind", "truth", "verdict", "names", "rivals", "result"), CASES)
def test_every_class_of_outcome(kind, truth, verdict, names, rivals, result):
    o = score_case(label(kind, *truth), finding(verdict, *names, rivals=rivals))
    assert o.result == result
    assert o.right == (result in RIGHT)


def test_all_results_are_exercised_and_explained():
    assert {case[-1] for case in CASES} | {"failed"} == set(MEANING)


def test_a_failed_workflow_is_wrong_and_keeps_its_reason():
    o = score_case(label("none"), None, reason="exit code 1: no start converged")
    assert (o.result, o.right, o.as_json()["reason"]) == ("failed", False, "exit code 1: no start converged")


@pytest.mark.parametrize(
    ("verdict", "names", "result"),
    [("unlisted", (), "flagged"), ("ambiguous", ("drag",), "flagged"), ("named", ("drag",), "wrong_name")],
)
def test_without_its_entry_a_case_is_outside_the_catalogue(verdict, names, result):
    assert score_case(label("single", "cogging"), finding(verdict, *names), left_out=["cogging"]).result == result


def test_wilson_interval_equals_its_formula():
    n, p, z = 40, 0.9, 1.959963984540054
    centre, half = (
        (p + z * z / (2 * n)) / (1 + z * z / n),
        z / (1 + z * z / n) * math.sqrt(p * 0.1 / n + z * z / (4 * n * n)),
    )
    row = rate(36, n)
    assert (row["low"], row["high"]) == pytest.approx((centre - half, centre + half), rel=1e-12)
    assert rate(0, 0)["share"] is None


def test_intervals_are_held_against_the_truth_in_the_catalogues_terms():
    told = {"cogging_sin": (0.021, 0.001), "cogging_cos": (0.5, 0.001), "cogging_number": (9.0, 0.1)}
    effect = {"id": "cogging", "parameters": {k: Estimate.normal(v, s, "").as_json() for k, (v, s) in told.items()}}
    hidden = {"cogging": {"cogging": 0.02, "cogging_phase": 0.0, "cogging_number": 9.1}}
    o = score_case(label("single", "cogging", hidden=hidden), finding("named") | {"effects": [effect]})
    assert {p.parameter: p.inside for p in o.parameters} == {
        "cogging_sin": True, "cogging_cos": False, "cogging_number": True,
    }  # fmt: skip
    row = coverage([o])
    assert (row["all"]["hits"], row["all"]["n"]) == (2, 3)
    assert row["parameters"]["cogging.cogging_cos"]["hits"] == 0


def test_a_locked_neighbour_behind_a_tendon_carries_a_share_of_the_link_alone():
    tendon = {"inertia": 0.6 * BASE["inertia"], "rotor_inertia": 0.4 * BASE["inertia"]}
    lock = {"lock_coupling": 1e-5, "lock_inertia": 2e-5}
    share = lock["lock_coupling"] ** 2 / (lock["lock_inertia"] * tendon["inertia"])
    effect = {"id": "lock_compliance", "parameters": {"lock_share": Estimate.normal(share, 1e-9, "1").as_json()}}
    case = label("pair", "lock_compliance", "tendon_slack", hidden={"lock_compliance": lock, "tendon_slack": tendon})
    (found,) = score_case(case, finding("named") | {"effects": [effect]}).parameters
    assert found.inside


def test_the_map_of_parameters_names_what_exists_on_both_sides():
    ids = {p.id for e in catalogue().values() for p in e.parameters}
    assert {*SAME, *FORMULAS} <= ids
    assert {f"{prefix}_{part}" for prefix in WAVES for part in ("sin", "cos")} <= ids
    known = {*JOINT.neutral(), "scatter"}
    assert {*SAME.values(), *(name for pair in WAVES.values() for name in pair)} <= known
    share = true_value("lock_share", {"lock_coupling": 1e-4, "lock_inertia": 2e-4}, BASE)
    assert share == pytest.approx(0.25)  # M·J − m² is positive for a share below 1


def test_settled_counts_only_what_is_named_exactly_afterwards():
    told = {"run": "", "tells": True}
    first = [score_case(label("single", "cogging"), finding("ambiguous", "drag", next_experiment=told))] * 3
    again = [score_case(label("single", "cogging"), finding("named", id)) for id in ("cogging", "drag")]
    row = count_settled(first, again)
    assert (row["proposed"], row["settled"]["hits"], row["settled_wrongly"]["hits"]) == (3, 1, 1)


def test_a_proposal_becomes_options():
    proposal = {"torque_amplitude_Nm": 0.01, "frequency_rad_s": 4.0, "separation_over_noise": 9.0, "run": "words"}
    assert options_of(proposal) == ["--amplitude=0.01", "--frequency=4.0"]


def outcomes() -> list[Outcome]:
    made = [score_case(label(k, *t), finding(v, *n, rivals=r)) for k, t, v, n, r, _ in CASES]
    return [*made, score_case(label("scatter", "amplitude_scatter"), finding("named", "amplitude_scatter", "drag"))]


def test_summary_counts_what_was_put_in():
    figures = summary(outcomes(), [], [])
    assert figures["right"]["hits"] == 8
    assert figures["right"]["n"] == len(CASES) + 1
    assert figures["false_alarms"]["white_noise"]["hits"] == 3
    assert figures["false_alarms"]["white_noise"]["n"] == 4
    assert figures["false_alarms"]["beside_scatter"]["hits"] == 1
    assert figures["outside_the_catalogue"]["confident_wrong_name"]["hits"] == 1
    matrix = figures["confusion"]
    assert matrix["cogging"] == {
        "ambiguous": 1, "ambiguous, truth among": 2, "cogging": 1, "nothing": 1, "several, in part": 1,
        "torque_ripple": 1, "unlisted": 1,
    }  # fmt: skip
    assert sum(n for row in matrix.values() for n in row.values()) == len(CASES) + 1
    assert confusion([]) == {}
    assert summarise_spread([None, 1.0, 3.0])["median"] == 2.0


def study() -> dict[str, Any]:
    made = outcomes()
    return {
        "schema": "blind/1", "command": "python -m studies.blind.run", "date": "2026-01-01", "git": "abc",
        "machine": "", "wall_s": 60.0, "workers": 1, "worked_through": len(made), "asked": {"cases": len(made)},
        "meaning": MEANING,
        **summary(made, [], []), "cases": [o.as_json() for o in made], "leave_one_out_cases": [],
    }  # fmt: skip


def test_the_page_is_made_from_the_json_alone(tmp_path: Path):
    path = tmp_path / "blind.json"
    path.write_text(json.dumps(study()))
    done = CliRunner().invoke(main, [str(path)])
    assert done.exit_code == 0, done.output
    assert "Right verdicts: 8 of 20 (40 %" in done.stdout
    page = (tmp_path / "blind.md").read_text()
    assert page == blind_page(study(), "blind.png")
    assert "wrong_name" in page
    assert (tmp_path / "blind.png").read_bytes().startswith(b"\x89PNG")


def test_a_page_of_something_else_is_refused(tmp_path: Path):
    (tmp_path / "x.json").write_text('{"schema": "other"}')
    assert CliRunner().invoke(main, [str(tmp_path / "x.json")]).exit_code == 2
    assert CliRunner().invoke(main, [str(tmp_path / "absent.json")]).exit_code == 2


def test_the_workflow_cannot_import_the_maker_of_the_cases(tmp_path: Path):
    make_cases(tmp_path, 1, 3, kinds=("none",), inputs="table3")
    code = "import sys, discrepancy.run; print([m for m in sys.modules if m.startswith('virtual_device')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cases", "labels.json"]
