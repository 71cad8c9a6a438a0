"""The native FMU in FMI 3.0: valid, described as in 2.0, and with the same bits."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.simulation import simulate_fmu
from fmpy.validation import validate_fmu
from lxml import etree

from haptid.fmu_build.building.packaging import build_fmu
from haptid.support.errors import InputError
from tests.fmu_build.fmi3_client import FMPY, Client3, fmu3
from tests.fmu_build.fmu_cases import NAMES, STEP, Client, equations, fmu, names, torques

T = STEP * np.arange(101)
FIELDS = (
    *("name", "description", "causality", "variability", "initial", "unit"),
    *("displayUnit", "min", "max", "nominal", "start"),
)


@pytest.mark.parametrize("name", NAMES)
def test_is_valid(name: str):
    assert validate_fmu(str(fmu3(name).path)) == []


def test_the_build_description_fits_its_schema():
    with zipfile.ZipFile(fmu3().path) as archive:
        root = etree.fromstring(archive.read("sources/buildDescription.xml"))
        assert root.find(".//SourceFile").get("name") == "all.c"
        assert {"documentation/index.html", "terminalsAndIcons/icon.png"} <= set(archive.namelist())
        assert b"sets their derivatives" not in archive.read("documentation/index.html")
    etree.XMLSchema(file=str(FMPY / "schema" / "fmi3" / "fmi3BuildDescription.xsd")).assertValid(root)


@pytest.mark.parametrize("name", NAMES)
def test_says_of_each_variable_what_fmi_2_says(name: str):
    old, new = (fmpy.read_model_description(str(fmu(name, kind).path)) for kind in ("native", "native3"))
    described = [[tuple(getattr(v, f) for f in FIELDS) for v in d.modelVariables] for d in (old, new)]
    assert described[1][1:] == described[0]
    assert new.modelVariables[0].causality == "independent"
    for what in ("outputs", "derivatives", "initialUnknowns"):
        uses = [
            {u.variable.name: [d.name for d in u.dependencies] for u in getattr(description, what)}
            for description in (old, new)
        ]
        assert uses[0] == uses[1]
        assert uses[0]
    states = {v.name: v.derivative.name for v in new.modelVariables if v.derivative is not None}
    assert states == {f"der({state})": state for state in names(equations(name), equations(name).states)}


@pytest.mark.parametrize("name", NAMES)
def test_co_simulation_gives_the_bits_of_fmi_2(name: str):
    e, u = equations(name), torques(equations(name), T)
    expected = Client(fmu(name, "native")).start().go().run(e, T, u)
    np.testing.assert_array_equal(Client3(fmu3(name)).start().go().run(e, T, u), expected)
    assert np.ptp(expected[:, 0]) > 1e-5


def test_fmpy_simulates_it_as_it_does_fmi_2():
    e = equations("joints01")
    signals = np.zeros(T.size, dtype=[("time", "f8"), *((x, "f8") for x in names(e, e.inputs))])
    signals["time"] = T
    for column, values in zip(names(e, e.inputs), torques(e, T).T, strict=True):
        signals[column] = values
    options = {"input": signals, "output": names(e, e.outputs), "stop_time": T[-1], "output_interval": STEP}
    old, new = (
        simulate_fmu(str(fmu("joints01", kind).path), fmi_type="CoSimulation", **options)
        for kind in ("native", "native3")
    )
    np.testing.assert_array_equal(new.tolist(), old.tolist())
    assert np.ptp(new[names(e, e.outputs)[0]]) > 1e-5


def test_model_exchange_by_cvode_agrees_with_co_simulation():
    options = {"start_values": {"joint4.torque": 5e-3}, "stop_time": 0.5, "output_interval": STEP}
    fast, exact = (
        simulate_fmu(str(fmu3().path), fmi_type=kind, relative_tolerance=1e-9, output=["joint4.reading"], **options)
        for kind in ("CoSimulation", "ModelExchange")
    )
    np.testing.assert_allclose(fast["joint4.reading"], exact["joint4.reading"], rtol=0, atol=2e-7)
    assert np.ptp(exact["joint4.reading"]) > 1e-2


def test_fits_keep_fmi_2(tmp_path: Path):
    with pytest.raises(InputError, match=r"FMI 2\.0"):
        build_fmu(equations("joint4"), tmp_path / "x.fmu", kind="native3", identification=True)
