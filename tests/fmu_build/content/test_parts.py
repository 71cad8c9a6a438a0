"""Units, archives, pictures, universal binaries, parameter sets."""

from __future__ import annotations

import math
import struct
import zlib
from zipfile import ZipFile

import fmpy
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from haptid.fmu_build.content.picture import HEIGHT, WIDTH, picture
from haptid.fmu_build.description.identity import guid_of
from haptid.fmu_build.description.units import parse_unit
from haptid.fmu_build.exchange.archive import pack, unpack
from haptid.fmu_build.exchange.ssp import write_ssp
from haptid.fmu_build.exchange.ssv import write_ssv
from haptid.fmu_build.native.mach_o import universal
from haptid.model.joint.parameter_table import joint_parameters
from tests.fmu_build.fmu_cases import fmu


@pytest.mark.parametrize(
    ("text", "exponents", "factor"),
    [
        ("1", {}, 1.0),
        ("rad", {"rad": 1}, 1.0),
        ("N m s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}, 1.0),
        ("N m/rad^3", {"kg": 1, "m": 2, "s": -2, "rad": -3}, 1.0),
        ("N.m/rad3", {"kg": 1, "m": 2, "s": -2, "rad": -3}, 1.0),
        ("N.m/(rad.s)", {"kg": 1, "m": 2, "s": -3, "rad": -1}, 1.0),
        ("1/s", {"s": -1}, 1.0),
        ("deg/ms", {"rad": 1, "s": -1}, math.pi / 180 * 1e3),
    ],
)
def test_units(text: str, exponents: dict[str, int], factor: float):
    unit = parse_unit(text)
    assert dict(unit.exponents) == exponents
    assert unit.factor == pytest.approx(factor)


def test_unknown_units_are_named():
    with pytest.raises(ValueError, match="furlong"):
        parse_unit("furlong/s")


@pytest.mark.parametrize("prismatic", [False, True])
def test_all_units_of_the_parameter_table_are_known(prismatic: bool):
    for q in joint_parameters(prismatic=prismatic):
        assert parse_unit(q.unit).factor == 1.0


@given(st.dictionaries(st.text("abcdef/", min_size=1).filter(lambda s: s.strip("/") == s), st.binary(max_size=200)))
def test_archives_round_trip_and_do_not_depend_on_order(files: dict[str, bytes]):
    data = pack(files)
    assert unpack(data) == files
    assert pack(dict(reversed(files.items()))) == data


def test_guids_follow_the_content():
    assert guid_of(b"a", "b") == guid_of(b"a", "b") != guid_of(b"ab")
    assert len(guid_of("x")) == 38


def test_picture_is_a_png_with_a_line_in_it():
    t = np.linspace(0, 1, 50)
    data = picture(t, np.sin(6 * t))
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", data[16:24]) == (WIDTH, HEIGHT)
    start = data.index(b"IDAT") + 4
    length = struct.unpack(">I", data[start - 8 : start - 4])[0]
    rows = np.frombuffer(zlib.decompress(data[start : start + length]), dtype=np.uint8).reshape(HEIGHT, 1 + 3 * WIDTH)
    assert 0.004 < (rows[:, 1:] < 100).mean() < 0.2


def test_universal_binaries_hold_their_slices():
    slices = [struct.pack("<III", 0xFEEDFACF, processor, 3) + bytes([processor & 255]) * 100 for processor in (7, 12)]
    data = universal(*slices)
    magic, count = struct.unpack_from(">II", data)
    assert (magic, count) == (0xCAFEBABE, 2)
    for i, piece in enumerate(slices):
        processor, subtype, offset, size, alignment = struct.unpack_from(">IIIII", data, 8 + 20 * i)
        assert (processor, subtype) == struct.unpack_from("<II", piece, 4)
        assert offset % (1 << alignment) == 0
        assert data[offset : offset + size] == piece


def test_parameter_sets_satisfy_the_published_schema(tmp_path):
    path = write_ssv(tmp_path / "p.ssv", {"joint4.inertia": 1.5e-4, "joint4.Kp": 1.0}, {"joint4.inertia": "kg m^2"})
    folder = fmpy.__path__[0] + "/ssp/schema/"
    schema = etree.XMLSchema(etree.parse(folder + "SystemStructureParameterValues.xsd"))
    document = etree.parse(str(path))
    schema.assertValid(document)
    values = {p.get("name"): float(p[0].get("value")) for p in document.getroot()[0]}
    assert values == {"joint4.inertia": 1.5e-4, "joint4.Kp": 1.0}


def test_systems_satisfy_the_published_schema_and_define_every_unit_they_name(tmp_path):
    built = fmu("joint4", "native").path
    path = write_ssp(tmp_path / "s.ssp", {"a": built, "b": built}, [], parameters={"a": {"joint4.spring.Ks": 0.02}})
    folder = fmpy.__path__[0] + "/ssp/schema/"
    with ZipFile(path) as archive:
        system = etree.fromstring(archive.read("SystemStructure.ssd"))
        values = etree.fromstring(archive.read("resources/a.ssv"))
    etree.XMLSchema(etree.parse(folder + "SystemStructureDescription.xsd")).assertValid(system)
    etree.XMLSchema(etree.parse(folder + "SystemStructureParameterValues.xsd")).assertValid(values)
    for document in (system, values):
        used = {node.get("unit") for node in document.iter("{*}Real")} - {None}
        defined = {node.get("name"): {k: int(x) for k, x in node[0].items()} for node in document.iter("{*}Unit")}
        assert used
        assert set(defined) == used
    assert defined == {"N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1}}
    bound = [node.get("source") for node in system.iter("{*}ParameterBinding")]
    assert bound == ["resources/a.ssv"]
