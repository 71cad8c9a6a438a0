"""Check of the interpreter: requirements of pyproject.toml in, the unmet ones out; change to the project's .venv.

Standard library only, because it runs before anything is installed.
"""

from __future__ import annotations

import ast
import os
import platform
import re
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import NoReturn

from haptid.support.interrupts import end_at_interrupt

ROOT = Path(__file__).resolve().parents[2]
VENV_PYTHON = ROOT / ".venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
BAD_SETUP = 2
UNFINISHED = "haptid-installation-unfinished"
"""Name of a file beside the installed packages while an installation copies: a killed installation stays marked."""

_REQUIREMENT = re.compile(r"^(?P<name>[\w.-]+)\s*(\[[^]]*\])?\s*(?P<bounds>[^;]*?)\s*(;\s*(?P<marker>.*))?$")
_EXTRA = re.compile(r"""(\s*and\s*)?extra\s*==\s*["'](?P<extra>[^"']*)["']""")
_SELF = re.compile(r"^haptid\[(?P<extras>[^]]*)\]$")
_HERE = {
    "implementation_name": sys.implementation.name,
    "os_name": os.name,
    "platform_machine": platform.machine(),
    "platform_python_implementation": platform.python_implementation(),
    "platform_system": platform.system(),
    "python_full_version": platform.python_version(),
    "python_version": ".".join(platform.python_version_tuple()[:2]),
    "sys_platform": sys.platform,
}
_OPERATORS = {ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}


@dataclass(frozen=True, slots=True)
class Requirement:
    """One requirement of the project.

    Parameters
    ----------
    text
        Line as pyproject.toml has it.
    name
        Name of the distribution.
    bounds
        Pairs of operator and version, all of which have to hold.
    """

    text: str
    name: str
    bounds: tuple[tuple[str, tuple[int, ...]], ...]

    @property
    def met(self) -> bool:
        """Whether the interpreter in use has the distribution in a version within the bounds."""
        try:
            installed = _version(metadata.version(self.name))
        except metadata.PackageNotFoundError:
            return False
        return all(_holds(installed, operator, bound) for operator, bound in self.bounds)


def _version(text: str) -> tuple[int, ...]:
    """Return the leading numbers of a version: ``1.10.0rc1`` gives (1, 10, 0)."""
    match = re.match(r"\d+(\.\d+)*", text)
    return tuple(int(part) for part in match[0].split(".")) if match else ()


def _holds(installed: tuple[int, ...], operator: str, bound: tuple[int, ...]) -> bool:
    width = max(len(installed), len(bound))
    a, b = ((*v, *(0,) * (width - len(v))) for v in (installed, bound))
    return {">=": a >= b, ">": a > b, "<": a < b, "<=": a <= b, "==": a == b, "!=": a != b}[operator]


def applies(marker: str | None) -> bool:
    """Return whether an environment marker holds on this machine.

    A marker of an unknown form counts as true: the installer, which reads all forms, decides.

    Parameters
    ----------
    marker
        Marker of a requirement, as ``sys_platform == "linux"``; None or empty where there is none.

    Returns
    -------
    bool
        True where it holds, is absent or has an unknown form.
    """
    if not marker:
        return True
    try:
        return _holds_here(ast.parse(marker, mode="eval").body)
    except (SyntaxError, ValueError, KeyError):
        return True


def _holds_here(node: ast.expr) -> bool:
    """Evaluate ``and``, ``or`` and comparisons of one variable with one text: the grammar of markers is Python's."""
    if isinstance(node, ast.BoolOp):
        parts = [_holds_here(value) for value in node.values]
        return all(parts) if isinstance(node.op, ast.And) else any(parts)
    if not isinstance(node, ast.Compare) or not isinstance(node.left, ast.Name):
        raise ValueError(ast.dump(node))
    wanted = str(ast.literal_eval(node.comparators[0]))
    name, operator = node.left.id, _OPERATORS[type(node.ops[0])]
    if name.startswith("python_"):
        release = wanted.removesuffix(".*")
        installed = _version(_HERE[name])
        if release != wanted:  # ``== '3.14.*'`` compares as many numbers as it names
            installed = installed[: len(_version(release))]
        return _holds(installed, operator, _version(release))
    return (_HERE[name] == wanted) == (operator == "==")


def parse_requirement(text: str) -> Requirement | None:
    """Parse one requirement.

    Parameters
    ----------
    text
        Requirement as in pyproject.toml: name, bounds of the version, and perhaps a marker.

    Returns
    -------
    Requirement or None
        None where the requirement's marker does not hold on this machine.

    Raises
    ------
    ValueError
        Where the text is no requirement.
    """
    match = _REQUIREMENT.match(text)
    if match is None:
        msg = f"pyproject.toml: cannot read the requirement {text!r}"
        raise ValueError(msg)
    if not applies(match["marker"]):
        return None
    bounds = re.findall(r"([<>=!]=|[<>])\s*([^,\s]+)", match["bounds"])
    return Requirement(text, match["name"], tuple((operator, _version(version)) for operator, version in bounds))


def requirements(*, dev: bool = False, extra: str | None = None) -> tuple[Requirement, ...]:
    """List the project's requirements that apply to this machine.

    Parameters
    ----------
    dev
        Whether requirements of the development tools are included, with those of every extra that they name.
    extra
        Extra whose requirements are included.

    Returns
    -------
    tuple of Requirement
        Those of pyproject.toml in a clone, otherwise those in the metadata of the installed wheel.
    """
    if not in_clone():
        return tuple(r for r in map(parse_requirement, _installed_lines(extra)) if r is not None)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"].get("optional-dependencies", {})
    lines = project["project"]["dependencies"] + (extras[extra] if extra else [])
    lines += project["dependency-groups"]["dev"] if dev else []
    return tuple(r for r in map(parse_requirement, _with_own_extras(lines, extras)) if r is not None)


def _with_own_extras(lines: Sequence[str], extras: Mapping[str, Sequence[str]]) -> list[str]:
    """Return requirements with the lines of the project's own extras in place of their names, as ``haptid[docs]``."""
    expanded: list[str] = []
    for line in lines:
        own = _SELF.match(line)
        if own is None:
            expanded.append(line)
            continue
        for name in own["extras"].split(","):
            expanded += _with_own_extras(extras[name], extras)
    return expanded


def in_clone() -> bool:
    """Say whether this is a clone, not an installed wheel.

    Returns
    -------
    bool
        True where pyproject.toml stands beside the packages.
    """
    return (ROOT / "pyproject.toml").is_file()


def _installed_lines(extra: str | None) -> list[str]:
    """Return the requirements that the installed wheel states, those of an extra without its marker."""
    lines = []
    for line in metadata.requires("haptid") or []:
        text, _, marker = line.partition(";")
        named = _EXTRA.search(marker)
        if named is None:
            lines.append(line)
        elif named["extra"] == extra:
            lines.append("; ".join(part for part in (text.strip(), _EXTRA.sub("", marker).strip()) if part))
    return lines


def missing(*, dev: bool = False, extra: str | None = None) -> tuple[Requirement, ...]:
    """Return the requirements that the interpreter in use does not meet.

    Parameters
    ----------
    dev, extra
        As in `requirements`.

    Returns
    -------
    tuple of Requirement
        All requirements where an installation did not end: its packages may lack files.
    """
    half = unfinished_mark().exists()
    return tuple(r for r in requirements(dev=dev, extra=extra) if half or not r.met)


def unfinished_mark() -> Path:
    """Locate the mark `UNFINISHED` among the packages of the interpreter in use.

    Returns
    -------
    Path
        Path of the mark, which exists only while an installation is unfinished.
    """
    return Path(sysconfig.get_path("purelib")) / UNFINISHED


def replace_process(arguments: Sequence[str | Path]) -> NoReturn:
    """Replace this process by another program; on Windows run the program and exit with its exit code.

    Parameters
    ----------
    arguments
        Path of the program, and its arguments.
    """
    command = [str(a) for a in arguments]
    if sys.platform == "win32":
        sys.exit(subprocess.run(command, check=False).returncode)
    os.execv(command[0], command)


def in_venv() -> bool:
    """Say whether the interpreter in use is that of the project's .venv.

    Returns
    -------
    bool
        True there, False in any other environment.
    """
    return Path(sys.prefix).resolve() == (ROOT / ".venv").resolve()


def ready(extra: str | None = None) -> None:
    """Let ``python -m package.command`` run under an interpreter that has the requirements, or exit with the remedy.

    Packages that hold a command call this when they are imported. It acts only while ``python -m`` looks for the
    command (``sys.argv[0]`` is then ``-m``), so that it costs an import as a library nothing.

    Parameters
    ----------
    extra
        Extra that the whole package needs; none where None.
    """
    if sys.argv[:1] != ["-m"] or not in_clone():  # where haptid is installed, its installer saw to it
        return
    end_at_interrupt()
    exit_where_lacking(extra)


def exit_where_lacking(extra: str | None = None) -> None:
    """Run the command again under the project's .venv where packages lack here, or exit with the remedy in one line.

    Parameters
    ----------
    extra
        Extra that the whole package needs; none where None.
    """
    lacking = missing(extra=extra)
    if not lacking:
        return
    names = ", ".join(r.name for r in lacking)
    if not in_clone():
        todo = "install haptid again with its requirements (pip install haptid)"
        sys.stderr.write(f"error: {sys.executable} lacks {names}; {todo}\n")
        sys.exit(BAD_SETUP)
    if VENV_PYTHON.is_file() and not in_venv():
        options = sys.orig_argv[1:]
        replace_process([VENV_PYTHON, *options])
    verb = extra if extra and not missing() else "fmu"
    sys.stderr.write(f"error: {sys.executable} lacks {names}; run `make {verb}` first\n")
    sys.exit(BAD_SETUP)
