"""Archives of FMUs: whatever is wrong is one line, and nothing is written outside the folder."""

from __future__ import annotations

import io
import stat
import zipfile
from dataclasses import replace

import fmpy
import pytest

from haptid.identification.foreign.archive import unpack_checked
from haptid.identification.thresholds import THRESHOLDS
from haptid.support.errors import InputError
from tests.identification.foreign_cases import DESCRIPTION, content, write

XML = "modelDescription.xml"
NEITHER = DESCRIPTION.replace(
    '<CoSimulation modelIdentifier="small" canHandleVariableCommunicationStepSize="true"/>', ""
)
BOMB = '<!DOCTYPE a [<!ENTITY b "bbbbbbbb"><!ENTITY c "&b;&b;&b;">]>'


def refused(path, folder):
    before = sorted(folder.parent.rglob("*"))
    with pytest.raises(InputError) as caught:
        unpack_checked(path, folder)
    line = str(caught.value)
    assert len(line) <= 300
    outside = [p for p in sorted(folder.parent.rglob("*")) if folder not in p.parents]
    assert outside == [p for p in before if folder not in p.parents]
    return line


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "unpacked"
    made.mkdir()
    return made


def test_a_whole_archive_is_unpacked(tmp_path, folder):
    found = unpack_checked(write(tmp_path / "a.fmu", content()), folder)
    assert found.description.modelName == "small"
    assert (folder / XML).is_file()


@pytest.mark.parametrize("name", ["../evil", "/evil", "a/../../evil", "..\\evil", "C:evil", "\x1b[2J"])
def test_names_that_leave_the_folder(name, tmp_path, folder):
    path = write(tmp_path / "a.fmu", content() | {name: b"x"})
    assert "a name within the archive's folder" in refused(path, folder)
    assert not list(folder.iterdir())


def test_links(tmp_path, folder):
    path = write(tmp_path / "a.fmu", content())
    link = zipfile.ZipInfo("resources/link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(link, "/etc/passwd")
    assert "got a link" in refused(path, folder)


def test_a_bomb_is_refused_by_its_size(tmp_path, folder, monkeypatch):
    assert THRESHOLDS.largest_unpacked_bytes > 1_000_000
    smaller = replace(THRESHOLDS, largest_unpacked_bytes=1_000_000)
    monkeypatch.setattr("haptid.identification.foreign.archive.THRESHOLDS", smaller)
    path = write(tmp_path / "a.fmu", content() | {"resources/zeros": bytes(5_000_000)})
    assert path.stat().st_size < 100_000
    assert "unpacked, got 3 of 5" in refused(path, folder)
    assert not list(folder.iterdir())


def test_damaged_archives(tmp_path, folder):
    path = write(tmp_path / "a.fmu", content())
    whole = path.read_bytes()
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        start = archive.infolist()[1].header_offset + 200
    changed = whole[:start] + bytes([whole[start] ^ 0xFF]) + whole[start + 1 :]
    for data in (b"", b"not a zip", whole[: len(whole) // 2], whole[:-30], changed):
        path.write_bytes(data)
        assert "an FMU, a whole zip archive" in refused(path, folder)
    assert "no such file" in refused(tmp_path / "none.fmu", folder)


@pytest.mark.parametrize(
    ("xml", "part"),
    [
        (None, "an FMU with modelDescription.xml"),
        (DESCRIPTION[:-30], "expected XML, got unclosed token"),
        (DESCRIPTION.replace("?>", "?>" + BOMB), "without document type and entities"),
        (DESCRIPTION.replace("UTF-8", "UTF-16").replace("?>", "?>" + BOMB).encode("utf-16"), "without document type"),
        (DESCRIPTION.replace('fmiVersion="2.0"', 'fmiVersion="1.0"'), "fmiVersion: expected 2.0 or 3.0, got '1.0'"),
        (DESCRIPTION.replace('fmiVersion="2.0"', ""), "got 'none'"),
        (NEITHER, "an FMU for co-simulation or model exchange, got neither"),
        (DESCRIPTION.replace('modelIdentifier="small"', 'modelIdentifier="../../small"'), "a name as C has them"),
        (DESCRIPTION.replace('modelIdentifier="small"', 'modelIdentifier="other"'), "for this platform"),
        (DESCRIPTION.replace('valueReference="1"', 'valueReference="one"'), "the FMI standard's schema"),
        ("<a/>", "got '<a>'"),
        ("<a>" * 100_000, "expected XML"),
        ("", "expected XML"),
    ],
)  # fmt: skip
def test_descriptions(xml, part, tmp_path, folder):
    files = content()
    files.pop(XML)
    if xml is not None:
        files[XML] = xml if isinstance(xml, bytes) else xml.encode()
    assert part in refused(write(tmp_path / "a.fmu", files), folder)


def test_binaries_of_another_platform_are_named(tmp_path, folder):
    files = {name.replace(fmpy.platform, "vax64"): data for name, data in content().items()}
    assert "binaries for vax64" in refused(write(tmp_path / "a.fmu", files), folder)
