"""Archive of a foreign FMU: path in, `Unpacked` out, checked before a byte of the archive is unpacked or run.

1. Check names, links, number and size of the entries.
2. Check that the model description is plain XML of FMI 2.0 or 3.0, without document type.
3. Unpack, read the model description with fmpy, and check that this platform's library is there. What breaks the schema
   is refused; what breaks a rule that the schema does not know is kept to be told, and the FMU runs.
"""

from __future__ import annotations

import re
import stat
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, NoReturn
from xml.parsers import expat

import fmpy
from fmpy.model_description import ValidationError
from fmpy.validation import validate_model_description

from haptid.identification.thresholds import THRESHOLDS
from haptid.support.errors import InputError, one_line

_DESCRIPTION = "modelDescription.xml"
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,199}")
"""Names of C, of at most 200 characters."""
_UNREADABLE = (zipfile.BadZipFile, zlib.error, OSError, EOFError, RuntimeError, NotImplementedError, ValueError)
"""Exceptions of zipfile for damaged archives, passwords and unknown methods of compression."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unpacked:
    """An archive on disk.

    Parameters
    ----------
    path, folder
        The archive, and the folder with its files.
    description
        Model description as fmpy read it.
    broken_rules
        Rules of the FMI standard that the description breaks, beyond the schema, in fmpy's words.
    """

    path: Path
    folder: Path
    description: Any
    broken_rules: tuple[str, ...] = ()

    @property
    def interface(self) -> str:
        """Interface that is simulated: ``CoSimulation`` where the FMU has it, else ``ModelExchange``."""
        return "CoSimulation" if self.description.coSimulation is not None else "ModelExchange"


def unpack_checked(path: Path, folder: Path) -> Unpacked:
    """Check a foreign FMU and unpack it.

    Parameters
    ----------
    path
        Archive of the FMU.
    folder
        Folder to unpack into, which exists and is empty.

    Returns
    -------
    Unpacked

    Raises
    ------
    InputError
        Where the archive is damaged, holds names that leave the folder, links, or more than
        `THRESHOLDS.largest_unpacked_bytes` bytes; where its description is no plain XML of FMI 2.0 or 3.0; where it has
        neither co-simulation nor model exchange for this platform.
    """
    if not path.is_file():
        raise InputError(str(path), expected="an FMU", got="no such file")
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            _check_entries(path, entries)
            _check_description(path, archive)
            archive.extractall(folder)
    except _UNREADABLE as error:
        got = one_line(str(error)) or type(error).__name__
        raise InputError(str(path), expected="an FMU, a whole zip archive", got=got) from None
    description, broken_rules = _read_description(path, folder)
    unpacked = Unpacked(path=path, folder=folder, description=description, broken_rules=broken_rules)
    _check_binary(unpacked)
    return unpacked


def _check_entries(path: Path, entries: list[zipfile.ZipInfo]) -> None:
    names = [entry.filename for entry in entries]
    for entry in entries:
        # zipfile shortens `filename` (at a NUL, for one): the name as the archive has it is what must be checked.
        where, name = f"{path}: {entry.filename!r}", entry.orig_filename
        if not _stays_inside(name):
            raise InputError(where, expected="a name within the archive's folder", got=repr(name))
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise InputError(where, expected="files and folders", got="a link")
    if len(set(names)) < len(names):
        raise InputError(str(path), expected="every name once", got="a name twice")
    size = sum(entry.file_size for entry in entries)
    if size > THRESHOLDS.largest_unpacked_bytes or len(entries) > THRESHOLDS.most_archive_entries:
        got = f"{len(entries)} of {size:.3g} bytes"
        most, largest = THRESHOLDS.most_archive_entries, THRESHOLDS.largest_unpacked_bytes
        raise InputError(str(path), expected=f"at most {most} files of {largest:.0e} bytes unpacked", got=got)
    if _DESCRIPTION not in names:
        raise InputError(str(path), expected=f"an FMU with {_DESCRIPTION}", got="a zip archive without it")


def _stays_inside(name: str) -> bool:
    parts = PurePosixPath(name).parts
    return name.isprintable() and not any(c in name for c in "\\:") and ".." not in parts and not name.startswith("/")


class _RefusedError(ValueError):
    """The XML declares a document type."""


def _check_description(path: Path, archive: zipfile.ZipFile) -> None:
    """Refuse a description that is malformed, of another FMI version, or declares entities, before fmpy reads it."""
    where = f"{path}: {_DESCRIPTION}"
    if archive.getinfo(_DESCRIPTION).file_size > THRESHOLDS.largest_description_bytes:
        raise InputError(where, expected=f"at most {THRESHOLDS.largest_description_bytes:.0e} bytes", got="more")
    version: list[str] = []

    def begin(name: str, attributes: dict[str, str]) -> None:
        if not version:
            version.append(attributes.get("fmiVersion", "none") if name == "fmiModelDescription" else f"<{name}>")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _refuse_entities
    parser.StartElementHandler = begin
    try:
        parser.Parse(archive.read(_DESCRIPTION), True)
    except expat.ExpatError as error:
        line = f"{where}, line {error.lineno}"
        raise InputError(line, expected="XML", got=expat.ErrorString(error.code)) from None
    except LookupError as error:
        raise InputError(where, expected="XML in an encoding that is known", got=str(error)) from None
    except _RefusedError:
        raise InputError(where, expected="XML without document type and entities", got="<!DOCTYPE") from None
    if version[0] != "2.0" and not version[0].startswith("3."):
        where = f"{where}: fmiVersion"
        raise InputError(where, expected="2.0 or 3.0", got=repr(version[0]))


def _refuse_entities(*_: object) -> NoReturn:
    raise _RefusedError


def _read_description(path: Path, folder: Path) -> tuple[Any, tuple[str, ...]]:
    """Return the description and the rules that it breaks: stock pythonfmu's own FMUs break one, and run well."""
    where = f"{path}: {_DESCRIPTION}"
    broken_rules: tuple[str, ...] = ()
    try:
        try:
            description = fmpy.read_model_description(str(folder))
        except ValidationError as error:
            description = fmpy.read_model_description(str(folder), validate=False)
            broken_rules = tuple(validate_model_description(description))
            if broken_rules != tuple(error.problems):  # fmpy stopped at the schema, before its own rules
                raise
    except Exception as error:  # fmpy raises bare exceptions, and whatever its conversions meet
        problems = getattr(error, "problems", None) or [str(error)]
        raise InputError(where, expected="what the FMI standard's schema says", got=str(problems[0])) from None
    if description.coSimulation is None and description.modelExchange is None:
        raise InputError(where, expected="an FMU for co-simulation or model exchange", got="neither of them")
    return description, broken_rules


def _check_binary(unpacked: Unpacked) -> None:
    path, description = unpacked.path, unpacked.description
    exchanged = unpacked.interface == "ModelExchange"
    identifier = (description.modelExchange if exchanged else description.coSimulation).modelIdentifier
    # The identifier becomes the name of the library that is loaded: a path in it would lead out of the folder.
    if not _IDENTIFIER.fullmatch(identifier or ""):
        where = f"{path}: {_DESCRIPTION}: modelIdentifier"
        raise InputError(where, expected="a name as C has them", got=repr(identifier))
    platform = fmpy.platform if description.fmiVersion == "2.0" else fmpy.platform_tuple
    library = f"{identifier}{fmpy.sharedLibraryExtension}"
    if not (unpacked.folder / "binaries" / platform / library).is_file():
        there = sorted(p.name for p in (unpacked.folder / "binaries").glob("*")) or ["none"]
        expected, got = f"binaries/{platform}/{library} for this platform", f"binaries for {', '.join(there)}"
        raise InputError(str(path), expected=expected, got=got, todo="ask its maker for this platform's")
