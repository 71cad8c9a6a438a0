"""Requirements as pyproject writes them, against what is installed."""

from __future__ import annotations

import ast
import importlib.metadata
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packaging.markers import Marker
from packaging.requirements import Requirement as Judge
from packaging.version import Version

from haptid.support.installing import environment, installation
from haptid.support.installing import lock_file as locked
from haptid.support.installing.environment import ROOT, VENV_PYTHON, parse_requirement, requirements

versions = st.lists(st.integers(0, 40), min_size=1, max_size=4).map(lambda parts: ".".join(map(str, parts)))
operators = st.sampled_from([">=", ">", "<", "<=", "==", "!="])


@given(installed=versions, bounds=st.lists(st.tuples(operators, versions), min_size=1, max_size=3))
def test_bounds_mean_what_the_standard_says(installed: str, bounds: list[tuple[str, str]]):
    text = "demo" + ",".join(operator + version for operator, version in bounds)
    requirement = parse_requirement(text)
    assert requirement is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importlib.metadata, "version", lambda _: installed)
        assert requirement.met == Judge(text).specifier.contains(Version(installed))


def test_every_requirement_of_this_project_is_read_and_met_here():
    for requirement in requirements(dev=True):
        judge = Judge(requirement.text)
        assert requirement.name == judge.name
        assert requirement.met, requirement.text
        assert judge.specifier.contains(importlib.metadata.version(judge.name), prereleases=True)


def test_an_extra_brings_the_extras_that_it_names():
    wanted = {r.name for r in requirements(extra="docs")}
    assert {"mkdocs", "arviz"} <= wanted
    assert "haptid" not in wanted
    assert "ruff" not in wanted


def test_absent_packages_are_missing(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(environment, "requirements", lambda **_: (parse_requirement("no-such-package-here>=1"),))
    assert [r.name for r in environment.missing()] == ["no-such-package-here"]


@pytest.mark.parametrize(
    ("marker", "applies"),
    [
        (f"sys_platform == '{sys.platform}'", True),
        (f"sys_platform != '{sys.platform}'", False),
        ("platform_machine == 'abacus'", False),
        ("python_version < '3.0'", False),
        ("python_full_version >= '3.11'", True),
        ("python_full_version == '3.10.*' or python_full_version > '3.10'", True),
        (f"python_full_version >= '3.11' and sys_platform != '{sys.platform}'", False),
        ("platform_release >= '20'", True),  # not read here: left to the installer
    ],
)
def test_markers(marker: str, applies: bool):
    assert (parse_requirement(f"demo>=1; {marker}") is not None) == applies


def test_every_marker_of_the_locked_files_is_read_as_the_standard_says():
    texts = "".join(path.read_text(encoding="utf-8") for path in locked.FOLDER.glob("*.txt"))
    markers = {line.partition(";")[2].strip(" \\") for line in texts.splitlines() if " ; " in line}
    assert len(markers) > 5
    for marker in markers:
        assert environment.applies(marker) == Marker(marker).evaluate(), marker


def test_an_unreadable_requirement_is_named():
    with pytest.raises(ValueError, match=r"cannot read the requirement '@@'"):
        parse_requirement("@@")


def test_bootstrap_is_readable_by_old_interpreters():
    ast.parse((environment.ROOT / "support" / "bootstrap.py").read_text(encoding="utf-8"), feature_version=(3, 5))


def test_the_project_is_not_installed_into_an_interpreter_that_the_system_manages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(sysconfig, "get_path", lambda _: str(tmp_path))
    assert installation.can_install_here()
    (tmp_path / "EXTERNALLY-MANAGED").touch()
    monkeypatch.setattr(sys, "prefix", sys.base_prefix)
    assert not installation.can_install_here()
    monkeypatch.setattr(sys, "prefix", str(tmp_path))  # a virtual environment of that interpreter is ours
    assert installation.can_install_here()


def test_nor_where_nothing_can_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sysconfig, "get_path", lambda _: str(tmp_path / "absent"))
    assert not installation.can_install_here()


@pytest.mark.skipif(VENV_PYTHON.is_file(), reason="there the commands run under the clone's .venv")
@pytest.mark.parametrize("module", ["haptid", "identification.run", "measurement.check", "uq.run", "report.run"])
def test_an_interpreter_without_any_package_is_told_in_one_line(module: str, bare_python: Path):
    done = subprocess.run(
        [bare_python, "-m", module, "check"], cwd=ROOT, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"error: {bare_python} lacks click, ")
    assert done.stderr.endswith("; run `make fmu` first\n")


def test_an_installed_command_without_its_packages_is_told_to_be_installed_again(monkeypatch, capsys):
    lacking = (environment.parse_requirement("click>=8"),)
    monkeypatch.setattr(environment, "missing", lambda **_: lacking)
    monkeypatch.setattr(environment, "in_clone", lambda: False)
    with pytest.raises(SystemExit) as ended:
        environment.exit_where_lacking()
    assert ended.value.code == 2
    told = "lacks click; install haptid again with its requirements (pip install haptid)\n"
    assert capsys.readouterr().err.endswith(told)


@pytest.fixture(scope="module")
def bare_python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An interpreter without any package."""
    folder = tmp_path_factory.mktemp("bare")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    return folder / "bin" / "python"
