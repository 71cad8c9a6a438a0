"""What an FMU says of its runs: noise is told beside the signal that it belongs to."""

from typing import Any

import pytest

from haptid.fmu_build.accuracy.verification import joint_in_tests


def make_test(residual: str) -> dict[str, Any]:
    figures = {"model": {"free_rmse": 0.006, "torque_rmse": 2.1, "torque_error": 0.039}}
    run = {"file": "a.csv", "use": "validate", "figures": figures, "rmse_rad": None, "rmse_per_joint": [2.1]}
    parameters = {"inertia": {"value": 95.0, "unit": "kg"}}
    return {
        "free_joints": [0],
        "residual": residual,
        "runs": [run],
        "sigma": {"a.csv": [0.03]},
        "parameters": parameters,
    }


@pytest.mark.parametrize(("residual", "open_loop", "torque"), [("position", 0.2, None), ("torque", None, 70.0)])
def test_the_noise_of_a_fitted_torque_is_not_that_of_a_position(residual, open_loop, torque):
    told = joint_in_tests([make_test(residual)], 0)
    over = {row["mode"]: row["over_noise"] for row in told["runs"]}
    assert over == {"open_loop": pytest.approx(open_loop), "torque": pytest.approx(torque)}
    assert ("times the sensor's noise" in told["verdict"]) is (residual == "position")
    assert told["unit"] == "m"
