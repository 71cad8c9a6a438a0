"""An FMU with other start values: archive and values in, the same archive with these start values out.

Only the attributes ``start`` of the named variables in ``modelDescription.xml`` change; every other byte of every file
stays. Binaries keep the start values that were compiled into them: a host sets those of the description before
initialisation, as the FMI standard asks.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.parsers import expat

from haptid.support.errors import InputError
from haptid.support.files.files import write_bytes

DESCRIPTION = "modelDescription.xml"
_TAG = re.compile(rb"""<[^<>"']*(?:"[^"]*"[^<>"']*|'[^']*'[^<>"']*)*>""")
_START = re.compile(rb"""(\sstart\s*=\s*)("[^"]*"|'[^']*')""")
_ENCODING = re.compile(rb"""^<\?xml[^>]*encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")


def write_with_starts(source: Path, path: Path, values: Mapping[str, float]) -> Path:
    """Write an FMU with other start values.

    Parameters
    ----------
    source
        Archive of the FMU.
    path
        Archive to write.
    values
        Start value by variable.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    InputError
        Where the description names no such variable, or ``path`` cannot be written.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(source) as whole, zipfile.ZipFile(stream, "w") as changed:
        for entry in whole.infolist():
            content = whole.read(entry)
            if entry.filename == DESCRIPTION:
                content = with_starts(content, values, f"{source}: {DESCRIPTION}")
            # The entry's own name, date, mode and compression are taken over.
            changed.writestr(entry, content)
    return write_bytes(path, stream.getvalue())


def with_starts(description: bytes, values: Mapping[str, float], where: str) -> bytes:
    """Put other start values into a model description of FMI 2.0 or 3.0.

    Parameters
    ----------
    description
        Content of ``modelDescription.xml``, in any encoding that Python knows.
    values
        Start value by variable.
    where
        Name of the description, for errors.

    Returns
    -------
    bytes
        The description in the same encoding; all else keeps its bytes.

    Raises
    ------
    InputError
        Where a variable is not there.
    """
    encoding = _encoding(description)
    text = description.decode(encoding).encode("utf-8")
    places = _places(text)
    lacking = [name for name in values if name not in places]
    if lacking:
        raise InputError(where, expected=f"a variable {lacking[0]}", got="none with a start value")
    # From the last place to the first, so that the places before a change stay right.
    for name in sorted(values, key=lambda name: -places[name]):
        tag = _TAG.match(text, places[name])
        if tag is not None:
            text = text[: tag.start()] + _with_start(tag.group(), values[name]) + text[tag.end() :]
    return text.decode("utf-8").encode(encoding)


def _encoding(description: bytes) -> str:
    if description.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if description.startswith(b"\xef\xbb\xbf"):
        return "utf-8-sig"
    declared = _ENCODING.match(description)
    return declared.group(1).decode("ascii") if declared else "utf-8"


def _places(text: bytes) -> dict[str, int]:
    """Return the place of the tag that holds a variable's start value, by the variable's name."""
    places: dict[str, int] = {}
    parser = expat.ParserCreate(encoding="utf-8")
    path: list[str] = []
    named = ""

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal named
        path.append(tag)
        if len(path) < 3 or path[1] != "ModelVariables":
            return
        # FMI 3.0 has the start value in the variable's own tag, FMI 2.0 in the tag of its type within.
        if len(path) == 3:
            named = attributes.get("name", "")
            if tag != "ScalarVariable":
                places[named] = parser.CurrentByteIndex
        elif len(path) == 4 and path[2] == "ScalarVariable" and named not in places:
            places[named] = parser.CurrentByteIndex
        elif len(path) == 4 and tag == "Alias":
            # An alias of FMI 3.0 has the value of the variable around it.
            places[attributes.get("name", "")] = places[named]

    def end(_: str) -> None:
        path.pop()

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.Parse(text, True)
    return places


def _with_start(tag: bytes, value: float) -> bytes:
    number = repr(float(value)).encode("ascii")
    if _START.search(tag):
        return _START.sub(lambda found: found.group(1) + b'"' + number + b'"', tag, count=1)
    end = -2 if tag.endswith(b"/>") else -1
    return tag[:end].rstrip() + b' start="' + number + b'"' + tag[end:]
