"""The reference of the Python API as a page: signatures and docstrings in, Markdown out."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

from docs.parts.tables import table
from haptid.api.campaign import Campaign
from haptid.api.identified import Identified
from haptid.api.missing import Missing
from haptid.api.posteriors import Posteriors
from haptid.identification.problem.options import FitOptions
from haptid.support.errors import HaptidError, InputError, NumericalError

CLASSES = (Campaign, Identified, Posteriors, Missing, FitOptions, HaptidError, InputError, NumericalError)
"""Public names, which `haptid` offers, in the order in which a program needs them."""
_HEADING = re.compile(r"^(Parameters|Returns|Yields|Raises|Warns|Notes)\n-+\n", re.MULTILINE)


def api_page() -> str:
    """Return the page: one section a class, one part a method that has no underscore."""
    text = "# Python API\n\n`from haptid import " + ", ".join(one.__name__ for one in CLASSES) + "`\n\n"
    text += "[How it is used](../tutorial/through_python.md).\n\n"
    return text + "".join(_class_section(one) for one in CLASSES)


def _class_section(one: type) -> str:
    text = f"## {one.__name__}\n\n{_render(inspect.getdoc(one) or '')}"
    for name, member in _members(one):
        kind = inspect.getattr_static(one, name)
        doc = _render(inspect.getdoc(member) or "")
        if isinstance(kind, property):
            text += f"### `{one.__name__}.{name}`\n\n{doc}"
        else:
            text += f"### `{one.__name__}.{name}`\n\n```python\n{_signature(name, member)}\n```\n\n{doc}"
    return text


def _members(one: type) -> Iterator[tuple[str, Any]]:
    """Yield the methods and properties that the class itself defines."""
    for name, member in vars(one).items():
        if name.startswith("_") or (not isinstance(member, property | classmethod) and not inspect.isfunction(member)):
            continue
        yield name, member if isinstance(member, property) else getattr(one, name)


def _signature(name: str, member: Any) -> str:
    """Return a call with one argument a line; annotations are texts as the code has them."""
    signature = inspect.signature(member)
    lines: list[str] = []
    for one in signature.parameters.values():
        if one.name == "self":
            continue
        if one.kind is inspect.Parameter.KEYWORD_ONLY and "*" not in lines:
            lines.append("*")
        default = "" if one.default is inspect.Parameter.empty else f" = {one.default!r}"
        lines.append(f"**{one.name}" if one.kind is inspect.Parameter.VAR_KEYWORD else one.name)
        lines[-1] += f": {one.annotation}{default}"
    joined = "".join(f"\n    {line}," for line in lines)
    returned = signature.return_annotation
    return f"{name}({joined}\n) -> {returned}" if lines else f"{name}() -> {returned}"


def _render(doc: str) -> str:
    """Return a docstring of numpy's style as Markdown: each of its sections becomes a table or a paragraph."""
    first, *rest = _HEADING.split(doc)
    text = _words(first)
    for title, body in zip(rest[::2], rest[1::2], strict=True):
        entries = _entries(body)
        if title == "Notes" or not all(meaning for _, meaning in entries):
            text += f"**{title}** {_words(body)}"
        else:
            text += f"**{title}**\n\n" + table(("", ""), ((f"`{name}`", meaning) for name, meaning in entries)) + "\n"
    return text


def _entries(body: str) -> list[tuple[str, str]]:
    """Return name and meaning of each entry; an entry's meaning is indented below its name."""
    entries: list[tuple[str, list[str]]] = []
    for line in body.rstrip().splitlines():
        if line and not line.startswith(" "):
            entries.append((line, []))
        elif entries and line.strip():
            entries[-1][1].append(line.strip())
    return [(name, _mark_code(" ".join(lines))) for name, lines in entries]


def _words(text: str) -> str:
    paragraphs = [" ".join(part.split()) for part in text.strip().split("\n\n")]
    return "".join(f"{_mark_code(part)}\n\n" for part in paragraphs if part)


def _mark_code(text: str) -> str:
    return text.replace("``", "`")
