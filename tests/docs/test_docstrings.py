"""What others call states its parameters, returns and errors in its docstring.

Ruff checks the sections that are there (D417, DOC102, DOC202, DOC403). Its rules for missing sections ask the same of
private functions, where a line is enough; so the public ones are checked here.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest

from haptid.support.installing.environment import ROOT

PACKAGES = (
    "support", "model", "virtual_device", "measurement", "fmu_build", "identification", "noise", "uq", "discrepancy",
    "report", "api", "studies", "haptid",
)  # fmt: skip
EXEMPT = {"property", "cached_property", "command"}
"""Decorators: a property is one value, which its sentence names; the docstring of a command is its help."""
NOTHING = {"None", "NoReturn", "Iterator[None]"}
"""Annotations of functions that hand nothing to their caller."""


def lacking(source: str, place: str) -> Iterator[str]:
    """Yield a line for each part that a public docstring of a module lacks."""
    for name, node, owner in public_functions(ast.parse(source)):
        # A class states how it is made in its own docstring.
        told = ast.get_docstring(owner if owner and node.name == "__init__" else node) or ""
        if told.startswith("See `"):  # as the protocol says it
            continue
        stated = names_in(section(told, "Parameters"))
        missing = [f"{argument} in Parameters" for argument in arguments(node, owner) if argument not in stated]
        handed = node.returns is not None and ast.unparse(node.returns) not in NOTHING
        if handed and not section(told, "Returns") and not section(told, "Yields"):
            missing.append("Returns")
        errors = section(told, "Raises")
        missing += [f"{error} in Raises" for error in raised(node.body) if error not in errors]
        yield from (complaint(place, node, name, part) for part in missing)
    for node in public_classes(ast.parse(source)):
        stated = names_in(section(ast.get_docstring(node) or "", "Parameters"))
        yield from (
            complaint(place, node, node.name, f"{field} in Parameters")
            for field in undocumented_fields(node)
            if field not in stated
        )


def complaint(place: str, node: ast.FunctionDef | ast.ClassDef, name: str, part: str) -> str:
    return f"{place}, line {node.lineno}: {name}: expected {part}, got nothing of it in the docstring"


def public_classes(module: ast.Module) -> list[ast.ClassDef]:
    return [node for node in module.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]


def public_functions(module: ast.Module) -> Iterator[tuple[str, ast.FunctionDef, ast.ClassDef | None]]:
    """Yield full name, node and class of the public functions of a module and of its public classes."""
    for owner in (None, *public_classes(module)):
        for node in (owner or module).body:
            if not isinstance(node, ast.FunctionDef) or decorators(node) & EXEMPT:
                continue
            if not node.name.startswith("_") or node.name in {"__init__", "__call__"}:
                yield (f"{owner.name}.{node.name}" if owner else node.name), node, owner


def decorators(node: ast.FunctionDef | ast.ClassDef) -> set[str]:
    """Return the last names of the decorators, ``command`` for ``@click.command()``."""
    called = [d.func if isinstance(d, ast.Call) else d for d in node.decorator_list]
    return {ast.unparse(d).rpartition(".")[2] for d in called}


def arguments(node: ast.FunctionDef, owner: ast.ClassDef | None) -> list[str]:
    """Return the names of the arguments without self, cls and those that begin with an underscore."""
    a = node.args
    every = [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, (a.vararg, a.kwarg))]
    first = 1 if owner and "staticmethod" not in decorators(node) else 0
    return [argument.arg for argument in every[first:] if not argument.arg.startswith("_")]


def raised(body: list[ast.stmt]) -> list[str]:
    """Return the names of the errors that a body raises itself, functions within it left out."""
    found: list[str] = []
    left: list[ast.AST] = [*body]
    while left:
        node = left.pop()
        if isinstance(node, ast.FunctionDef):
            continue
        if isinstance(node, ast.Raise) and node.exc is not None:
            error = ast.unparse(node.exc.func if isinstance(node.exc, ast.Call) else node.exc).rpartition(".")[2]
            # Names in lower case are errors that were caught, or that a function makes.
            found += [error] if error[:1].isupper() else []
        left += ast.iter_child_nodes(node)
    return sorted(set(found))


def undocumented_fields(node: ast.ClassDef) -> list[str]:
    """Return the public fields of a dataclass that no string follows."""
    if "dataclass" not in decorators(node):
        return []
    found = []
    for field, after in zip(node.body, [*node.body[1:], None], strict=True):
        told = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and not told:
            found.append(field.target.id)
    return [name for name in found if not name.startswith("_")]


def section(docstring: str, title: str) -> str:
    found = re.search(rf"^{title}\n-+\n(.+?)(?=^\S[^\n]*\n---|\Z)", docstring, re.DOTALL | re.MULTILINE)
    return found[1] if found else ""


def names_in(parameters: str) -> set[str]:
    """Return the names that stand in the lines that are not indented, stars and types left out."""
    lines = [line.partition(" : ")[0] for line in parameters.splitlines() if line[:1].strip()]
    return {name.strip().lstrip("*") for line in lines for name in line.split(",")}


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_of_what_others_call_are_complete(package: str):
    folder = ROOT / package
    # haptid/ holds links to the other packages beside modules of its own.
    paths = [path for path in sorted(folder.rglob("*.py")) if path.resolve().is_relative_to(folder.resolve())]
    assert paths
    found = [line for path in paths for line in lacking(path.read_text("utf-8"), path.relative_to(ROOT).as_posix())]
    assert not found, "\n".join(found)


WHOLE = '''
def scale(value: float, *more: float, factor: float = 2.0) -> float:
    """Scale.

    Parameters
    ----------
    value, *more
        Numbers.
    factor
        Factor [1].

    Returns
    -------
    float
        Number.

    Raises
    ------
    ValueError
        Where it is negative.
    """
    raise ValueError
'''


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("", "", []),
        ("value, *more", "value", ["more in Parameters"]),
        ("Returns\n    -------", "Notes\n    -----", ["Returns"]),
        ("ValueError\n        Where", "KeyError\n        Where", ["ValueError in Raises"]),
        ("Scale.", "See `scale`.", []),
        ("def scale", "def _scale", []),
        ("def scale", "@click.command()\ndef scale", []),
    ],
)
def test_a_missing_part_is_found(old: str, new: str, expected: list[str]):
    told = [f"a.py, line 2: scale: expected {part}, got nothing of it in the docstring" for part in expected]
    assert list(lacking(WHOLE.replace(old, new, 1), "a.py")) == told


def test_fields_of_dataclasses_and_arguments_of_constructors_stand_in_the_docstring_of_the_class():
    fields = '@dataclass(frozen=True)\nclass A:\n    """A."""\n    x: float\n    y: float\n    """Y."""\n    _z: int\n'
    made = 'class B:\n    """B."""\n    def __init__(self, x: float) -> None: ...\n'
    found = [line.split(", got")[0] for source in (fields, made) for line in lacking(source, "a.py")]
    assert found == ["a.py, line 2: A: expected x in Parameters", "a.py, line 3: B.__init__: expected x in Parameters"]
