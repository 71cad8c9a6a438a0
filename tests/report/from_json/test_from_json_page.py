"""Pages made of a result's JSON alone: its numbers stand at their places."""

from __future__ import annotations

from haptid.report.from_json.page import page_from_json
from tests.report.reading import Seen, seen

IDENTIFICATION = {
    "campaign": "A wrist", "measured": False,
    "configurations": [{
        "free_joints": [4], "outcome": "converged", "outcome_sentence": "converged",
        "parameters": {
            "Ks": {"value": 0.0278, "std": 0.0011, "unit": "N m/rad", "status": "identified"},
            "Kp": {"value": 1.25, "std": None, "unit": "1", "status": "fixed"},
        },
        "runs": [
            {"file": "a.csv", "use": "fit", "rmse_over_noise": 1.03},
            {"file": "b.csv", "use": "validate", "rmse_over_noise": {"q": 1.27, "v": None}},
        ],
    }],
}  # fmt: skip
POSTERIOR = {
    "campaign": "A wrist", "measured": True,
    "joints": [{"joint": 4, "parameters": {
        "Ks": {"median": 0.0278, "intervals": {"0.5": [0.0251, 0.0306], "0.95": [0.0199, 0.0362]}, "unit": "N m/rad"}
    }}],
}  # fmt: skip
FINDING = {
    "joint": 4, "measured": True, "verdict": "named", "sentence": "Cogging is missing.",
    "effects": [{"id": "cogging", "parameters": {"a": {"value": 2.3e-3, "std": 6.7e-5, "unit": "N m"}}}],
    "gap": {"validate": {"before": 5.83e-3, "after": 1.34e-3, "noise": 3.2e-4}, "sealed": None},
}  # fmt: skip


def shown(data: dict) -> Seen:
    return seen(page_from_json(data, "a.json").html)


def test_an_identification_has_its_parameters_and_its_scores():
    page = shown(IDENTIFICATION)
    assert page.table("Joint 4", heading="parameter").rows == [
        ["parameter", "value ± std", "unit", "status"],
        ["Ks", "0.0278 ± 0.0011", "N m/rad", "identified"],
        ["Kp", "1.25", "1", "fixed"],
    ]
    assert page.table("Joint 4", heading="run").rows == [
        ["run", "use", "RMS × noise"], ["a.csv", "fit", "1.03"], ["b.csv", "validate", "q 1.27, v –"],
    ]  # fmt: skip


def test_an_error_far_beyond_the_range_is_not_shown():
    """A spring's equilibrium was told as (0.0 ± 3.7)e+12 m where no spring was."""
    (entry,) = IDENTIFICATION["configurations"]
    open_one = {"value": 2.6, "std": 3.7e12, "unit": "m", "lower": -3.0, "upper": 4.8}
    told = {
        "epos": {**open_one, "status": "unidentifiable"},
        "vs": {**open_one, "status": "prior"},
        "x": {**open_one, "std": 7.0, "status": "unidentifiable"},
    }
    page = shown({**IDENTIFICATION, "configurations": [{**entry, "parameters": told}]})
    assert page.table("Joint 4", heading="parameter").column("value ± std") == ["–", "2.6", "2.6 ± 7.0"]


def test_a_value_of_a_model_that_does_not_fit_is_uncertain():
    (entry,) = IDENTIFICATION["configurations"]
    page = shown({**IDENTIFICATION, "configurations": [{**entry, "outcome": "above_noise"}]})
    assert page.table("Joint 4", heading="parameter").column("status") == ["uncertain", "fixed"]


def test_a_posterior_has_its_interval_of_95_per_cent():
    assert shown(POSTERIOR).table("Joint 4").rows == [
        ["parameter", "median", "95 % interval", "unit"], ["Ks", "0.0278", "0.0199 … 0.0362", "N m/rad"],
    ]  # fmt: skip


def test_a_finding_has_its_effect_and_its_gap():
    page = shown(FINDING)
    assert page.table("What is missing").rows[1:] == [["cogging", "a", "0.002300 ± 0.000067", "N m"]]
    assert page.table("Before and after").rows == [
        ["runs", "RMS before", "after", "noise"], ["validate", "0.00583", "0.00134", "0.00032"],
    ]  # fmt: skip
