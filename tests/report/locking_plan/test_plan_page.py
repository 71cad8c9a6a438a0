"""Page and text of a locking plan: the numbers of a known plan stand at their places."""

from __future__ import annotations

import pytest

from haptid.report.locking_plan.page import plan_page
from haptid.report.locking_plan.text import tell_plan
from haptid.support.tables import text_of
from tests.report.reading import Seen, seen

PLAN = {
    "title": "A wrist",
    "locking_order": [[1], [0, 1]],
    "parameters": ["m1", "L1zz", "m0"],
    "unknowns_at_once": 37,
    "largest_stage": 23,
    "stages": [
        {
            "free_joints": [1], "contains": ["m1", "L1zz"], "new": ["m1", "L1zz"], "joint_parameters": 7,
            "combinations_at_home": 3, "combinations_anywhere": 5, "new_combinations": 4,
            "coefficients": [
                {
                    "id": "inertia", "initial": 1.234e-4, "prior_std": 5.6e-5, "unit": "kg m²",
                    "of": {"L1zz": 1.0, "m1": -0.37},
                },
            ],
        },
        {
            "free_joints": [0, 1], "contains": ["m1", "L1zz", "m0"], "new": ["m0"], "joint_parameters": 14,
            "combinations_at_home": 8, "combinations_anywhere": 11, "new_combinations": 6,
            "coefficients": [
                {"id": "gravity_cos", "initial": 0.42, "prior_std": 0.19, "unit": "N m", "of": {"m0": -1.0}},
            ],
        },
    ],
    "base_parameters": {
        "count": 19, "rank_numeric": 18, "reached_with_locked_joints_at_home": 12,
        "reached_with_locked_joints_anywhere": 16, "formulas": ["m0 + 0.5 m1", "L1zz"],
    },
    "unidentifiable": [{"what": ["m0", "m1"], "why": "only their sum acts"}],
    "assumptions": ["The base stands still."],
    "software": {"haptid": "0.1.0"},
    "excitation": [
        {
            "joint": 1, "warnings": ["the torque is small"],
            "runs": [
                {"amplitude_Nm": 0.0543, "frequency_rad_s": 2.31}, {"amplitude_Nm": 0.0765, "frequency_rad_s": 6.87},
            ],
            "expected": [
                {"id": "inertia", "initial": 1.234e-4, "std_before": 4.3e-6, "std_after": 1.7e-6, "unit": "kg m²"}
            ],
        },
        {"joint": 0, "reason": "it holds no load"},
    ],
    "postures": {
        "coefficient_accuracy": 0.031, "torque_error_first_guesses": 0.46, "torque_error_home": 0.17,
        "torque_error_planned": 0.082,
        "tests": [{"free_joints": [1], "locked_positions_rad": [0.613, 0.0]}],
    },
}  # fmt: skip


@pytest.fixture
def page() -> Seen:
    return seen(plan_page(PLAN).html)


def test_configurations_are_locked_and_counted(page):
    locked, counted = (table for table in page.tables if table.section == "Order")
    assert locked.rows == [["configuration", "joint 0", "joint 1"], ["1", "L", "U"], ["2", "U", "U"]]
    assert counted.row("1") == {
        "free joints": "1", "inertial parameters in it": "2", "new ones": "2", "friction, spring, gain": "7",
        "combinations at home": "3", "combinations over postures": "5", "new combinations": "4",
    }  # fmt: skip
    assert list(counted.row("0+1").values())[1:] == ["3", "1", "14", "8", "11", "6"]


def test_ones_stand_where_a_parameter_is_first_met(page):
    assert page.table("Table of ones").rows == [
        ["parameter", "1", "0+1"], ["m1", "1", ""], ["L1zz", "1", ""], ["m0", "", "1"],
    ]  # fmt: skip


def test_equations_have_guess_and_width(page):
    table = page.table("Equations")
    assert table.header == ["free joints", "coefficient", "first guess", "unit", "of the links"]
    assert table.rows[1:] == [
        ["1", "inertia", "0.0001234 ± 5.6e-05", "kg m²", "L1zz − 0.37 m1"],
        ["0+1", "gravity_cos", "0.42 ± 0.19", "N m", "− m0"],
    ]


def test_the_lead_has_the_three_counts(page):
    assert page.paragraphs[0] == (
        "Lock the joints in the order 1, 0+1. The full model has 19 base parameters; these tests reach 12 with the "
        "locked joints at home and 16 over other lock postures."
    )
    assert page.table("What stays unidentifiable").rows[1:] == [["m0, m1", "only their sum acts"]]
    assert page.table("Base parameters of the full model").rows[1:] == [["1", "m0 + 0.5 m1"], ["2", "L1zz"]]


def test_runs_have_amplitude_and_frequency_and_errors_shrink(page):
    runs, errors = (table for table in page.tables if table.section == "Proposed runs")
    assert runs.rows[1:] == [["1", "0.0543 at 2.31, 0.0765 at 6.87"], ["0", "it holds no load"]]
    assert errors.row("1") == {
        "joint": "1", "parameter": "inertia", "first guess": "0.000123", "before": "4.3e-06", "after": "1.7e-06",
        "unit": "kg m²",
    }  # fmt: skip
    assert page.table("Proposed postures").rows[1:] == [["1", "+0.613, -"]]
    assert (
        "fitted to 3.1 %): 46 % from the first guesses, 17 % after the tests at home, 8.2 % with the proposed"
        in page.text
    )


def test_the_text_has_the_same_numbers():
    lines = text_of(tell_plan(PLAN)).splitlines()
    assert "Base parameters of the full model: 19 (exact), 18 (numeric rank); these tests reach 12 with" in lines[2]
    assert lines[2].endswith("at home, 16 over postures")
    assert lines[3] == "Unknowns: 37 at once, at most 23 in one stage"
    cells = [line.split() for line in lines]
    assert ["0+1", "3", "1", "14", "8", "11", "6"] in cells
    assert ["1", "inertia", "0.000123", "4.3e-06", "1.7e-06", "kg", "m²"] in cells


def test_a_plan_without_postures_has_a_sentence_in_place_of_an_empty_table():
    alone = {**PLAN, "postures": {**PLAN["postures"], "tests": []}}
    told, shown = text_of(tell_plan(alone)), seen(plan_page(alone).html)
    assert told.endswith("No lock postures beyond home are proposed.")
    assert "locked at [" not in told
    assert "No lock postures beyond home are proposed." in shown.paragraphs
    assert "Proposed postures" not in [table.section for table in shown.tables]
