"""No text of a device file is ever code: not in C, Python, XML or HTML, however it is written."""

from __future__ import annotations

import ast
import tomllib
import zipfile
from html.parser import HTMLParser
from importlib import resources
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from haptid.fmu_build.building.packaging import build_fmu, interface_for
from haptid.fmu_build.content.extras import extra_files
from haptid.fmu_build.description.fmi2_xml import model_description
from haptid.fmu_build.native.fmi2 import native_source
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.device.device_table import parse_device
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.kernel.generate import generate
from haptid.support.errors import InputError, one_line

MARK = "qqpayloadqq"
PIECES = ("*/", "\n", "\\\n", "??/", '"', "'''", '"""', "'", "<script>", "{{ 7*7 }}", "{% raw %}", "]]>", "&", "-->",
          "\0", "\x1b[2J", "\u202e", "$", "%n", "`id`", "#define ", "/*", "\\", "é", " ")  # fmt: skip
TEXTS = st.lists(st.sampled_from(PIECES), min_size=1, max_size=6).map(lambda parts: f"{MARK}{''.join(parts)}{MARK}")
TABLE = tomllib.loads((resources.files("haptid.model.device.built_in") / "arm6.toml").read_text(encoding="utf-8"))


def with_texts(text: str) -> dict[str, Any]:
    """Return a device's table with ``text`` in every field that takes any text."""
    table = {**TABLE, "title": text, "assumptions": [text], "notices": [text]}
    table["joints"] = [{**joint, "name": f"{text}{j}"} for j, joint in enumerate(TABLE["joints"])]
    table["links"] = [{**link, "title": text} for link in TABLE["links"]]
    return table


class Tags(HTMLParser):
    """The elements of a page, and the attributes that run code."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [tag, *(name for name, _ in attrs if name.startswith("on"))]


def page_of(equations: Equations) -> str:
    """Return the documentation that goes into the FMU."""
    interface = interface_for(equations, kind="native")
    files = extra_files(interface, text=equations.title, python=False, linear=True, provenance={})
    return files["documentation/index.html"].decode()


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(text=TEXTS)
def test_texts_stay_texts(text: str):
    plain = configuration_equations(parse_device(TABLE, "arm6.toml"), [5])
    equations = configuration_equations(parse_device(with_texts(text), "x.toml"), [5])
    assert MARK not in generate(equations).source
    interface = interface_for(equations, kind="native")
    assert native_source(interface, "guid") == native_source(interface_for(plain, kind="native"), "guid")
    root = ElementTree.fromstring(model_description(interface, guid="g", python=False, text=equations.title))
    assert root.get("description") == one_line(equations.title)
    assert Tags(page_of(equations)).found == Tags(page_of(plain)).found


@pytest.mark.parametrize("name", ["x */ int y; /*", "a\n", "a b", "a;b", "", "é", "<b>"])
@pytest.mark.parametrize("where", ["device", "link"])
def test_a_name_that_goes_into_code_is_an_identifier(name: str, where: str):
    table = with_texts("t")
    if where == "device":
        table["name"] = name
    else:
        table["links"] = [{**table["links"][0], "name": name}, *table["links"][1:]]
    with pytest.raises(InputError):
        parse_device(table, "x.toml")


def test_a_title_that_was_a_shell_command_is_a_title(tmp_path: Path):
    proof = tmp_path / "proof"
    payload = (
        "x */ int system(const char*); __attribute__((constructor)) static void f(void)"
        f'{{ system("touch {proof}"); }} /*'
    )
    equations = configuration_equations(parse_device(with_texts(payload), "x.toml"), [5])
    CompiledKernel.of(equations)
    for kind in ("python", "native"):
        made = build_fmu(equations, tmp_path / f"{kind}.fmu", kind=kind, platforms=this_platform())
        with zipfile.ZipFile(made.path) as archive:
            for name in archive.namelist():
                if name.endswith((".c", ".h")):
                    assert b"touch" not in archive.read(name)
                if name.endswith(".py"):
                    ast.parse(archive.read(name))
                    assert b"touch" not in archive.read(name)
    assert not proof.exists()
