"""The door ``haptid``: help without imports, unknown commands in one line."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

import haptid
from haptid.command_line import COMMANDS, main
from haptid.discrepancy.commands import STAGES as OFFERED
from haptid.discrepancy.finding.stages import STAGES
from haptid.model.device.reader import builtin_devices
from haptid.support.declaring import declaration
from haptid.support.errors import InputError
from haptid.support.installing.environment import ROOT
from haptid.version import version


def test_help_imports_no_package():
    script = "\n".join((
        "import runpy, sys",
        "try:",
        "    runpy.run_module('haptid', run_name='__main__')",
        "finally:",
        "    print(sorted(m for m in sys.modules if m.startswith('haptid.') or m == 'numpy'))",
    ))  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", script, "--help"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    # What Ctrl-C does needs the standard library alone.
    assert "['haptid.command_line', 'haptid.support', 'haptid.support.interrupts', 'haptid.version']" in done.stdout
    assert all(name in done.stdout for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_there(name: str):
    done = CliRunner().invoke(main, [name, "--help"])
    assert done.exit_code == 0
    assert "Usage: " in done.output
    assert f"haptid {name} " in done.output.split("Examples:")[1]
    assert "--json" in done.output


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_a_version(name: str):
    done = CliRunner().invoke(main, [name, "--version"])
    assert (done.exit_code, done.output) == (0, f"haptid, version {version()}\n")


@pytest.mark.parametrize(
    "loaded", ["click", "haptid.identification.commands", "haptid.identification.identify_campaign"]
)
def test_an_interruption_while_modules_are_loaded_is_one_line(loaded: str):
    """Within the first moments Ctrl-C ended with a traceback or with click's exit code 1."""
    script = f"""
import os, runpy, signal, sys

signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background inherits that it is ignored

class Interrupts:
    def find_spec(self, name, path=None, target=None):
        if name == {loaded!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupts())
sys.argv = ["haptid", "identify"]
runpy.run_module("haptid", run_name="__main__")
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "interrupted: nothing was finished yet\n")


def test_the_package_has_the_version_of_its_commands():
    assert haptid.__version__ == version()
    assert "__version__" in dir(haptid)


HEAVY = ("numpy", "pandas", "scipy", "sympy", "matplotlib", "cvxpy", "fmpy", "arviz")
"""Packages that take a second to import and that no help needs."""


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command_imports_nothing_heavy(name: str):
    script = "\n".join((
        "import sys",
        "from haptid.command_line import main",
        f"main([{name!r}, '--help'], standalone_mode=False)",
        f"print([m for m in {HEAVY} if m in sys.modules])",
    ))  # fmt: skip
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.endswith("[]\n")


def test_the_stages_offered_are_those_that_the_search_does():
    assert OFFERED == STAGES


def test_an_unknown_command_is_one_line_with_what_it_may_have_meant():
    done = CliRunner().invoke(main, ["identfy"])
    assert done.exit_code == 2
    assert done.output.count("\n") == 1
    assert done.output.endswith("got 'identfy'; did you mean identify?\n")


@pytest.mark.parametrize(
    ("typed", "completed"), [("haptid id", "identify"), ("haptid po", "posterior"), ("haptid identify --js", "--json")]
)
def test_the_shell_completes_commands_and_options(typed: str, completed: str):
    words = {"_HAPTID_COMPLETE": "bash_complete", "COMP_WORDS": typed, "COMP_CWORD": str(len(typed.split()) - 1)}
    command = [sys.executable, "-m", "haptid"]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | words, capture_output=True, text=True, check=True)
    assert done.stdout == f"plain,{completed}\n"


def complete(typed: str, folder: Path) -> list[str]:
    """Return what Bash is told to complete in a folder after the words of a command line."""
    words = {"_HAPTID_COMPLETE": "bash_complete", "COMP_WORDS": typed, "COMP_CWORD": str(typed.count(" "))}
    done = subprocess.run(
        [sys.executable, "-m", "haptid"], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT), **words},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.split("\n")[:-1]


@pytest.mark.parametrize(
    "typed", ["identify ", "missing my", "plan x", "fmus ../", "init tables --device x", "export --device "]
)
def test_the_shell_completes_files_where_an_argument_is_one(typed: str, tmp_path: Path):
    assert complete(f"haptid {typed}", tmp_path) == [f"file,{typed.rsplit(' ', maxsplit=1)[-1]}"]


def test_the_shell_completes_devices_and_tables(tmp_path: Path):
    (tmp_path / "tables").mkdir()
    for name in ("arm.urdf", "campaign.toml", "notes.md", "with blank.toml", "tables/leg.toml", "tables/val_1.csv"):
        (tmp_path / name).touch()
    built_in = [f"plain,{name}" for name in builtin_devices()]
    assert complete("haptid plan ", tmp_path) == complete("haptid fmus ", tmp_path)
    assert complete("haptid plan ", tmp_path) == [*built_in, "plain,arm.urdf", "plain,tables/"]
    assert complete("haptid plan free", tmp_path) == ["plain,freedom6s"]
    told = [*built_in, "plain,leg.toml", "plain,arm.urdf", "plain,tables/"]
    assert complete("haptid init tables --device ", tmp_path) == told
    assert complete("haptid init tables --validate v", tmp_path) == ["plain,val_1.csv"]
    assert complete("haptid init no_such --validate v", tmp_path) == ["file,v"]


def test_a_completion_imports_neither_numpy_nor_a_reader_of_devices():
    script = "\n".join((
        "import sys",
        "from haptid.command_line import main",
        "try:",
        "    main(prog_name='haptid')",
        "finally:",
        "    print(*sys.modules)",
    ))  # fmt: skip
    words = {"_HAPTID_COMPLETE": "bash_complete", "COMP_WORDS": "haptid plan ", "COMP_CWORD": "2"}
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | words, capture_output=True, text=True, check=True)
    *completed, modules = done.stdout.splitlines()
    assert "plain,freedom6s" in completed
    assert "haptid.model.commands" in modules.split()
    assert not {"numpy", "pandas", "sympy", "haptid.model.device.reader"} & set(modules.split())


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("quiet", [False, True])
def test_a_command_says_at_once_on_a_terminal_that_it_loads(quiet: bool, monkeypatch: pytest.MonkeyPatch):
    told = Terminal()
    monkeypatch.setattr("sys.stderr", told)
    monkeypatch.setattr(declaration.importlib, "import_module", lambda _: SimpleNamespace(work=lambda **_: 3))
    assert declaration.call("some.module", "work", quiet=quiet) == 3
    shown = told.getvalue()
    assert shown.startswith(declaration.LOADING) != quiet
    assert shown.endswith("\r") != quiet


def test_a_log_holds_nothing_before_an_error(monkeypatch: pytest.MonkeyPatch):
    told = io.StringIO()
    monkeypatch.setattr("sys.stderr", told)
    monkeypatch.setattr(declaration.importlib, "import_module", lambda _: SimpleNamespace(work=lambda **_: 3))
    assert declaration.call("some.module", "work", quiet=False) == 3
    assert not told.getvalue()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["init", "t", "--out", "o", "--resolution", "0,00077"],
         "error: haptid init: invalid value for '--resolution': '0,00077' is not a valid float; write a decimal point; "
         "see haptid init --help\n"),
        (["identify", "c", "--starts", "many"], "is not a valid integer"),
        (["identify", "c", "--outt", "o"], "error: haptid identify: no such option"),
        (["init", "t"], "error: haptid init: missing option '--out'; see haptid init --help\n"),
        (["export", "--from", "a.json", "--out", "a.fmu", "--kind", "natve"], "'natve' is not one of"),
        (["check", "a", "b"], "error: haptid check: got unexpected extra argument"),
        (["--jsn", "check"], "error: haptid: no such option"),
    ],
)  # fmt: skip
def test_a_wrong_command_line_is_one_line_that_names_the_help(arguments: list[str], told: str):
    done = CliRunner().invoke(main, arguments, prog_name="haptid")
    assert done.exit_code == 2
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
    assert done.stderr.startswith("error: haptid")
    assert done.stderr.endswith("--help\n")
    assert told in done.stderr


def test_a_call_without_a_command_shows_the_help():
    done = CliRunner().invoke(main, [])
    assert "Usage: " in done.output
    assert "error: " not in done.output


def test_a_module_ends_in_one_line_too():
    done = subprocess.run(
        [sys.executable, "-m", "measurement.new", "t"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    told = "error: python -m measurement.new: missing option '--out'; see python -m measurement.new --help\n"
    assert (done.returncode, done.stderr) == (2, told)


@pytest.mark.parametrize(
    ("line", "error"), [("import no_such_package.part", InputError), ("import haptid.nothing", ModuleNotFoundError)]
)
def test_an_absent_package_is_one_line(line, error, tmp_path, monkeypatch):
    (tmp_path / "work_of_a_command.py").write_text(f"{line}\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "work_of_a_command", raising=False)
    with pytest.raises(error) as raised:
        declaration.call("work_of_a_command", "run", quiet=True)
    if error is InputError:
        assert "expected the package no_such_package, which haptid needs" in str(raised.value)
        assert "\n" not in str(raised.value)
