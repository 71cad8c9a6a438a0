"""What an identification that was read tells of its parameters, and how wrong arguments are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from haptid.api.identified import Identified
from haptid.support.errors import InputError

ESTIMATES = {
    "inertia": {"value": 2e-3, "std": 1e-5, "unit": "kg m^2", "status": "identified"},
    "Ks": {"value": 0.7, "std": 0.2, "unit": "N m/rad", "status": "unidentifiable"},
    "Kp": {"value": 1.0, "std": 0.0, "unit": "1", "status": "fixed"},
}
RUN = {"file": "a.csv", "use": "fit", "rmse_rad": 2e-3, "rmse_over_noise": 9.0}


def read(folder: Path, outcome: str) -> Identified:
    entry = {"free_joints": [0], "parameters": ESTIMATES, "outcome": outcome, "runs": [RUN]}
    content = {
        "schema": "identification/1", "device": "single_joint", "campaign": "a test", "measured": True,
        "configurations": [entry], "links": {}, "verification": {"runs": []},
    }  # fmt: skip
    (folder / "identification.json").write_text(json.dumps(content))
    return Identified.read(folder)


@pytest.mark.parametrize(("outcome", "told"), [("converged", "identified"), ("lonely", "uncertain")])
def test_a_value_of_a_model_that_does_not_fit_is_uncertain_here_too(outcome, told, tmp_path):
    """Terminal and report said so, and a script took the value for the machine's."""
    identified = read(tmp_path, outcome)
    assert list(identified.summary().status) == [told, "unidentifiable", "fixed"]
    assert f"<td>{told}</td>" in identified._repr_html_()


def test_the_summary_has_the_constant_torque_of_a_plain_model(tmp_path):
    read(tmp_path, "plain")
    file = tmp_path / "identification.json"
    content = json.loads(file.read_text())
    offset = {"value": 0.06, "std": 0.002, "unit": "N m"}
    content["configurations"][0]["baseline"] = {"parameters": {"Fc": {**offset, "value": 0.2}, "offset": offset}}
    file.write_text(json.dumps(content))
    row = Identified.read(tmp_path).summary().iloc[-1]
    assert row.name == ("joint 0", "offset")
    assert (row["value"], row["std"], row["status"]) == (0.06, 0.002, "uncertain")


def test_a_value_that_the_runs_do_not_tell_has_no_standard_deviation(tmp_path):
    rows = read(tmp_path, "converged").summary()
    assert list(rows["value"]) == [2e-3, 0.7, 1.0]
    assert np.array_equal(rows["std"], [1e-5, np.nan, 0.0], equal_nan=True)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda one: one.export_fmu("x.fmu", kind="foo"), "kind: expected one of python, native, native3, got 'foo'"),
        (lambda one: one.export_bodies("x.xml", form="sdf"), "form: expected one of urdf, mjcf, got 'sdf'"),
        (lambda one: one.export_bodies("x.xml", friction="dahl"), "friction: expected one of lugre, frictionloss"),
    ],
)
def test_an_unknown_kind_is_refused_in_one_line(call, told, tmp_path):
    with pytest.raises(InputError) as caught:
        call(read(tmp_path, "converged"))
    assert str(caught.value).startswith(told)
    assert "\n" not in str(caught.value)
