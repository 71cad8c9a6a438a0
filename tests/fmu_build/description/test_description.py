"""What the model description says, and that the archive is the same bytes for the same content."""

from __future__ import annotations

import math
import zipfile
from xml.etree import ElementTree

import fmpy
import pytest
import sympy as sp
from fmpy.validation import validate_fmu

from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu, interface_for
from haptid.fmu_build.description.fmi2_xml import model_description
from haptid.fmu_build.description.fmi3_xml import model_description3
from haptid.fmu_build.native.platforms import PLATFORMS, this_platform
from haptid.model.equations.equations import Equations, Input, Output, State
from haptid.support.errors import InputError
from tests.fmu_build.fmu_cases import FOLDER, KINDS, NAMES, equations, fmu


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", NAMES)
def test_is_valid(name: str, kind: Kind):
    assert validate_fmu(str(fmu(name, kind).path)) == []


@pytest.mark.parametrize("kind", KINDS)
def test_the_identification_fmu_is_valid(kind: Kind):
    assert validate_fmu(str(fmu("joint4", kind, identification=True).path)) == []


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", NAMES)
def test_every_variable_is_described(name: str, kind: Kind):
    description = fmpy.read_model_description(str(fmu(name, kind).path))
    units = {unit.name: unit for unit in description.unitDefinitions}
    assert units["rad"].displayUnits[0].name == "deg"
    assert units["N.m"].baseUnit.kg == 1
    assert not [name for name in units if {" ", "^"} & set(name)]
    for v in description.modelVariables:
        assert v.description
        assert v.unit in units
        assert v.nominal is not None
        assert (v.start is not None) == (v.causality in ("input", "parameter") or v.initial == "exact")
        if v.causality == "parameter":
            assert v.min is None or v.max is None or float(v.min) <= float(v.start) <= float(v.max)
            assert v.variability == "tunable"
    unknowns = {u.variable.name for u in description.initialUnknowns}
    assert {v.name for v in description.modelVariables if v.causality == "output"} <= unknowns
    assert float(description.defaultExperiment.stepSize) == 5e-4
    assert description.coSimulation.needsExecutionTool is (kind == "python")
    assert description.coSimulation.canSerializeFMUstate


def shown(built: Fmu) -> set[str]:
    return {v.name for v in fmpy.read_model_description(str(built.path)).modelVariables}


def test_names_are_structured():
    shown = {v.name for v in fmpy.read_model_description(str(fmu("joint4", "python").path)).modelVariables}
    assert {
        "joint4.friction.sigma0",
        "joint4.spring.Ks",
        "joint4.inertia",
        "joint4.torque",
        "joint4.friction.bristle",
    } <= shown
    whole = {v.name for v in fmpy.read_model_description(str(fmu("freedom6s", "native").path)).modelVariables}
    wanted = {"joint5.friction.Fc", "joint0.torque", "joint0.speed", "joint3.actuator.torque", "handle.position.x"}
    assert wanted | {"handle.quaternion.w", "handle.force.z"} <= whole


def test_dependencies_are_those_of_the_formulas():
    description = fmpy.read_model_description(str(fmu("joint4", "native").path))
    rates = {u.variable.name: {d.name for d in u.dependencies} for u in description.derivatives}
    assert rates["der(joint4.position)"] == {"joint4.velocity"}
    assert rates["der(joint4.friction.bristle)"] == {"joint4.velocity", "joint4.friction.bristle"}
    assert "joint4.torque" in rates["der(joint4.velocity)"]
    (output,) = description.outputs
    assert [d.name for d in output.dependencies] == ["joint4.position"]
    initial = {u.variable.name: {d.name for d in u.dependencies} for u in description.initialUnknowns}
    assert "joint4.friction.vs" in initial["der(joint4.friction.bristle)"]


def test_only_the_identification_fmu_shows_observer_and_sensitivities():
    plain = {v.name for v in fmpy.read_model_description(str(fmu("joint4", "native").path)).modelVariables}
    full = {
        v.name
        for v in fmpy.read_model_description(str(fmu("joint4", "native", identification=True).path)).modelVariables
    }
    assert not any("observer" in name or "sensitivity" in name or "slope" in name for name in plain)
    assert {"joint4.observer.gain", "joint4.observer.y", "joint4.torque_slope", "sensitivity.y.sigma0"} <= full


@pytest.mark.parametrize("kind", KINDS)
def test_same_content_same_bytes_other_content_other_guid(kind: Kind):
    first, e = fmu("joint4", kind), equations("joint4")
    again = build_fmu(e, FOLDER / f"again_{kind}.fmu", kind=kind, platforms=this_platform())
    assert again.path.read_bytes() == first.path.read_bytes()
    other = build_fmu(e, FOLDER / f"other_{kind}.fmu", kind=kind, platforms=this_platform(), values={"Ks": 0.0123})
    assert other.digest != first.digest
    guids = {fmpy.read_model_description(str(f.path)).guid for f in (first, again, other)}
    assert len(guids) == 2


def test_python_modules_are_told_apart_by_content():
    modules = set()
    for built in (fmu("joint4", "python"), fmu("joints01", "python"), fmu("joint4", "python", identification=True)):
        with zipfile.ZipFile(built.path) as archive:
            modules.add(archive.read("resources/slavemodule.txt"))
    assert len(modules) == 3


def _archive(built: Fmu) -> zipfile.ZipFile:
    return zipfile.ZipFile(built.path)


@pytest.mark.parametrize("kind", KINDS)
def test_carries_documentation_licence_picture_and_reference(kind: Kind):
    with _archive(fmu("joint4", kind)) as archive:
        assert archive.namelist()[0] == "modelDescription.xml"
        page = archive.read("documentation/index.html").decode()
        assert "<math" in page
        assert "joint4.friction.sigma0" in page
        assert b"BSD 3-Clause" in archive.read("documentation/licenses/license.txt")
        assert archive.read("model.png").startswith(b"\x89PNG")
        assert archive.read("documentation/joint4_ref.csv").startswith(b'"time","joint4.reading"')
        assert archive.read("documentation/joint4_in.csv").startswith(b'"time","joint4.torque"')
        assert archive.read("documentation/joint4_ref.opt").startswith(
            b"StartTime, 0.0\nStopTime, 2.0\nStepSize, 0.005\n"
        )
        assert all(entry.date_time == (1980, 1, 1, 0, 0, 0) for entry in archive.infolist())


def test_native_binaries_for_every_platform(tmp_path):
    built = build_fmu(equations("joint4"), tmp_path / "all.fmu", kind="native", platforms=PLATFORMS)
    with _archive(built) as archive:
        found = {name: archive.read(name)[:4] for name in archive.namelist() if name.startswith("binaries/")}
    assert found == {
        "binaries/linux64/joint4.so": b"\x7fELF",
        "binaries/aarch64-linux/joint4.so": b"\x7fELF",
        "binaries/win64/joint4.dll": found["binaries/win64/joint4.dll"],
        "binaries/darwin64/joint4.dylib": b"\xca\xfe\xba\xbe",
        "binaries/aarch64-darwin/joint4.dylib": b"\xcf\xfa\xed\xfe",
    }
    assert found["binaries/win64/joint4.dll"].startswith(b"MZ")


@pytest.mark.parametrize(("input_used", "reference"), [(True, 0), (False, 2)])
def test_setting_an_input_makes_outputs_stale_where_definitions_of_definitions_use_it(input_used: bool, reference: int):
    x, u, first, second = sp.symbols("x u first second", real=True)
    e = Equations(
        name="chain",
        title="chain",
        joints=(),
        states=(State(id="x", unit="1", description="state"),),
        inputs=(Input(id="u", unit="1", description="input"),),
        outputs=(Output(id="y", unit="1", description="output", expression=2 * second),),
        parameters=(),
        definitions=((first, 3 * u if input_used else 3 * x), (second, first + 1)),
        rhs=(-x,),
        rates=(sp.S.One,),
        mass_matrix=(),
    )
    assert interface_for(e, kind="native").stale_from == reference


def test_nominal_values_have_the_size_of_start_or_bounds():
    values = {"link1_I12": 1e-21, "link1_x": -2e-19, "link1_m": 0.1}
    variables = interface_for(equations("freedom6s"), kind="native", values=values).variables
    by_id = {v.id: v for v in variables}
    assert (by_id["link1_I12"].start, by_id["link1_x"].start, by_id["link1_m"].start) == (0.0, 0.0, 0.1)
    assert (by_id["link1_I12"].nominal, by_id["link1_m"].nominal) == (by_id["link1_I12"].maximum, 0.1)
    for v in variables:
        bound = max(abs(v.minimum), abs(v.maximum))
        assert not math.isfinite(bound) or v.nominal >= 1e-9 * bound


@pytest.mark.parametrize(("stated", "date"), [(None, "1980-01-01T00:00:00Z"), ("1700000000", "2023-11-14T22:13:20Z")])
def test_origin_and_date_are_stated(stated: str | None, date: str, monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    if stated is not None:
        monkeypatch.setenv("SOURCE_DATE_EPOCH", stated)
    interface = interface_for(equations("joint4"), kind="native")
    for text in (
        model_description(interface, guid="{}", python=False, text="joint"),
        model_description3(interface, token="{}", text="joint"),
    ):
        root = ElementTree.fromstring(text)
        assert root.get("generationDateAndTime") == date
        assert root.get("version") == equations("joint4").digest
        assert root.get("author") == "haptid"
        assert str(root.get("copyright")).startswith("Copyright")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    with pytest.raises(InputError, match="SOURCE_DATE_EPOCH: expected whole seconds"):
        model_description(interface, guid="{}", python=False, text="joint")


@pytest.mark.parametrize(
    ("friction", "drive", "display"), [(0.02, 0.0, "mN.m"), (0.02, 0.5, "mN.m"), (40.0, 0.5, None), (0.02, 5.0, None)]
)
@pytest.mark.parametrize("write", [model_description, model_description3])
def test_torques_are_shown_in_the_unit_of_their_size(write, friction: float, drive: float, display: str | None):
    """40 N m of friction were 40000 mN m in every simulator, and so were 5 N m of a drive with little friction."""
    stated = {"Fs": friction, "Fc": friction}
    interface = interface_for(equations("joint4"), kind="native", values=stated, largest_torque=drive)
    named = {"token": "{}"} if write is model_description3 else {"guid": "{}", "python": False}
    root = ElementTree.fromstring(write(interface, text="joint", **named))
    shown = [one.get("displayUnit") for one in root.iter() if one.get("unit") == "N.m"]
    assert len(shown) > 3
    assert set(shown) == {display}
    (unit,) = [one for one in root.iter("Unit") if one.get("name") == "N.m"]
    assert [one.get("name") for one in unit.iter("DisplayUnit")] == ([] if display is None else [display])
