"""The manifest of FMI-LS-REF: every file that it names lies in the archive, under a role of the standard."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import pytest

from haptid.fmu_build.content.references import MANIFEST, NAMESPACE, manifest_file
from tests.fmu_build.fmu_cases import KINDS, fmu

ROLE = re.compile(
    "document|requirement|specification|model|parameter|system|testcase|"
    "experiment(/(smoke-test|validation|uncertainty-analysis))?|result|method|rationale|report|request|delivery|"
    "configuration|signature|serialized-state(/.*)?|meta-data|other"
)
"""Roles of the schema of version 1.0.0-alpha.1."""


def places(path: Path) -> Iterator[tuple[str, str]]:
    """Yield role and name within the archive of each file of the manifest."""
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read(MANIFEST))
    assert root.tag == "fmiReferences"
    assert root.attrib[f"{{{NAMESPACE}}}fmi-ls-name"] == "org.fmi-standard.fmi-ls-ref"
    for related in root:
        assert related.tag == "Related"
        assert ROLE.fullmatch(related.attrib["role"])
        assert related.attrib["description"]
        steps: list[str] = []
        for part in (*PurePosixPath(MANIFEST).parent.parts, *PurePosixPath(related.attrib["source"]).parts):
            steps = steps[:-1] if part == ".." else [*steps, part]
        yield related.attrib["role"], "/".join(steps)


@pytest.mark.parametrize("kind", KINDS)
def test_every_file_of_the_manifest_lies_in_the_archive(kind):
    path = fmu("joint4", kind).path
    found = list(places(path))
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
    assert {name for _, name in found} <= names
    roles = {name: role for role, name in found}
    assert roles["resources/parameters.ssv"] == roles["extra/haptid/draws.csv"] == "parameter"
    assert roles["extra/haptid/verification.json"] == "report"
    assert {role for name, role in roles.items() if name.endswith("_ref.csv")} == {"result"}
    # nothing that haptid puts beside the code is left without a role
    beside = {name for name in names if name.startswith("extra/haptid/")}
    assert beside <= set(roles)


def test_names_without_a_role_are_left_out():
    (text,) = manifest_file(["modelDescription.xml", "documentation/index.html"]).values()
    assert text.decode().count("<Related") == 1
