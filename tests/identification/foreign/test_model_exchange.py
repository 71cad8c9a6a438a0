"""FMUs for model exchange alone: integrated by CVode with their events, they give what closed formulas say."""

from __future__ import annotations

import re
import zipfile

import numpy as np
import pytest

from haptid.identification.foreign.process import ForeignFmu
from tests.real_data import DATA

pytestmark = pytest.mark.real("foreign_fmus")
CO_SIMULATION = re.compile(rb"<CoSimulation[^>]*/>|<CoSimulation[^>]*>.*?</CoSimulation>", re.DOTALL)


def exchange_only(folder, name):
    """Copy a reference FMU without its co-simulation."""
    path = folder / f"{name.replace('/', '_')}.fmu"
    with zipfile.ZipFile(DATA / "foreign_fmus" / f"{name}.fmu") as whole, zipfile.ZipFile(path, "w") as part:
        for entry in whole.namelist():
            content = whole.read(entry)
            part.writestr(entry, CO_SIMULATION.sub(b"", content) if entry == "modelDescription.xml" else content)
    return path


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_an_exponential_is_integrated_closely_over_uneven_rows(version, tmp_path):
    t = np.array([0.0, 0.1, 0.35, 0.9, 2.0])
    with ForeignFmu(exchange_only(tmp_path, f"{version}/Dahlquist")) as fmu:
        assert fmu.interface == "ModelExchange"
        (x,) = fmu.simulate(t, start={"k": 0.5}, inputs={}, outputs=["x"]).T
    np.testing.assert_allclose(x, np.exp(-0.5 * t), rtol=1e-6)


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_a_ball_bounces_at_the_time_of_its_state_event(version, tmp_path):
    t = np.linspace(0.0, 0.7, 71)
    with ForeignFmu(exchange_only(tmp_path, f"{version}/BouncingBall")) as fmu:
        (h,) = fmu.simulate(t, start={"g": -9.0, "e": 0.8}, inputs={}, outputs=["h"]).T
    hit = np.sqrt(2.0 / 9.0)
    since = t - hit
    expected = np.where(since < 0, 1.0 - 4.5 * t**2, 0.8 * 9.0 * hit * since - 4.5 * since**2)
    np.testing.assert_allclose(h, expected, atol=1e-6)


def test_time_events_of_the_model_are_met(tmp_path):
    with ForeignFmu(exchange_only(tmp_path, "fmi2/Stair")) as fmu:
        (counter,) = fmu.simulate(np.arange(0.0, 3.0, 0.4), start={}, inputs={}, outputs=["counter"]).T
    assert counter.tolist() == [1, 1, 1, 2, 2, 3, 3, 3]


@pytest.mark.parametrize("linear", [False, True])
@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_outputs_of_a_row_belong_to_its_inputs_of_every_type(version, linear, tmp_path):
    whole, flag = ("Int32", "Boolean")
    force = np.array([1.0, -2.5, -2.5, 0.25])
    inputs = {
        "Float64_continuous_input": force,
        f"{whole}_input": np.array([3.0, 2.0, 1.0, 0.0]),
        f"{flag}_input": np.array([0.0, 1.0, 1.0, 0.0]),
    }
    outputs = ["Float64_continuous_output", f"{whole}_output", f"{flag}_output"]
    with ForeignFmu(exchange_only(tmp_path, f"{version}/Feedthrough")) as fmu:
        t = np.array([0.0, 0.1, 0.3, 0.4])
        read = fmu.simulate(t, start={}, inputs=inputs, outputs=outputs, linear=linear)
    np.testing.assert_array_equal(read, np.column_stack(list(inputs.values())))
