"""Read parameter sets of SSP 1.0 (section 6): SSV file in, one `Stated` per parameter out.

A file may come from a stranger, so only plain XML without document type and entities is read, and an element or an
attribute that the standard does not have is refused with its line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from haptid.fmu_build.description.units import BASE, Unit, parse_unit
from haptid.fmu_build.exchange.ssv import SSC, SSV
from haptid.support.errors import InputError
from haptid.support.files.files import read_content
from haptid.support.suggestion import did_you_mean

WANTED = "a parameter set (.ssv)"
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
BELOW = {
    "": ("ParameterSet",),
    "ParameterSet": ("Parameters", "Units", "EnumerationDefinitions", "Annotations"),
    "Parameters": ("Parameter",),
    "Parameter": ("Real", "Annotations"),
    "Units": ("Unit",),
    "Unit": ("BaseUnit", "Annotations"),
}
"""Child elements that an element may have; their namespace is checked separately."""
SKIPPED = ("Annotations", "EnumerationDefinitions")
"""Elements that are allowed but not read, with all that they contain."""
OF_SSC = ("Unit", "BaseUnit", "Annotations")
"""Elements of SSP's common namespace; Annotations are in it wherever they stand."""
ATTRIBUTES = {
    "Parameter": ("name", "id", "description"), "Real": ("value", "unit"), "Unit": ("name", "id", "description"),
    "BaseUnit": (*BASE, "factor", "offset"),
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Stated:
    """Hold one parameter as the file states it.

    Parameters
    ----------
    value
        In ``unit``; finite.
    unit
        None where the file states none.
    line
        Line of the file, for errors.
    """

    value: float
    unit: Unit | None
    line: int


@dataclass(slots=True)
class _Reader:
    """Hold the content that was read so far; its methods are the handlers of expat."""

    path: str
    parser: expat.XMLParserType = field(default_factory=lambda: expat.ParserCreate(namespace_separator=" "))
    open: list[str] = field(default_factory=list)
    parameter: str = ""
    unit: str = ""
    found: dict[str, tuple[float, str | None, int]] = field(default_factory=dict)
    units: dict[str, Unit] = field(default_factory=dict)

    def where(self) -> str:
        """Name the file and the line that the parser has reached."""
        return f"{self.path}, line {self.parser.CurrentLineNumber}"

    def refuse_entities(self, *_: object) -> NoReturn:
        """Refuse a document type, in which entities are declared."""
        raise InputError(self.where(), expected="XML without document type and entities", got="<!DOCTYPE")

    def begin(self, full: str, attributes: dict[str, str]) -> None:
        """Read one element's attributes."""
        space, _, name = full.rpartition(" ")
        above = self.open[-1] if self.open else ""
        self.open.append(name)
        if any(outer in SKIPPED for outer in self.open[:-1]):
            return
        allowed = BELOW.get(above, ())
        if name not in allowed or (name not in SKIPPED and space != (SSC if name in OF_SSC else SSV)):
            self._refuse_element(above, full, allowed)
        for key in attributes if name in ATTRIBUTES else ():
            if key not in ATTRIBUTES[name]:
                todo = did_you_mean(key, ATTRIBUTES[name])
                raise InputError(self.where(), expected=f"attributes of <{name}>", got=repr(key), todo=todo)
        reading = {
            "ParameterSet": self._begin_set, "Parameter": self._begin_parameter, "Real": self._read_value,
            "Unit": self._begin_unit, "BaseUnit": self._read_unit,
        }  # fmt: skip
        if name in reading:
            reading[name](attributes)

    def end(self, _: str) -> None:
        """Close an element; a parameter must have had its value by now."""
        closed = self.open.pop()
        if closed != "Parameter" or any(outer in SKIPPED for outer in self.open):
            return
        if math.isnan(self.found[self.parameter][0]):
            raise InputError(self.where(), expected=f"a <Real value=…> in {self.parameter!r}", got="none")

    def _begin_set(self, attributes: Mapping[str, str]) -> None:
        if attributes.get("version") != "1.0":
            got = repr(attributes.get("version", "none"))
            raise InputError(self.where(), expected='a <ParameterSet version="1.0">', got=got)

    def _begin_parameter(self, attributes: Mapping[str, str]) -> None:
        self.parameter = self._attribute("Parameter", "name", attributes)
        if self.parameter in self.found:
            got = f"{self.parameter!r} again (line {self.found[self.parameter][2]})"
            raise InputError(self.where(), expected="every parameter once", got=got)
        # NaN until its <Real> is read: a stated value is always finite.
        self.found[self.parameter] = (math.nan, None, self.parser.CurrentLineNumber)

    def _begin_unit(self, attributes: Mapping[str, str]) -> None:
        self.unit = self._attribute("Unit", "name", attributes)
        if self.unit in self.units:
            raise InputError(self.where(), expected="every unit once", got=repr(self.unit))

    def _refuse_element(self, above: str, full: str, allowed: Iterable[str]) -> NoReturn:
        space, _, name = full.rpartition(" ")
        where = f"an element in <{above}>" if above else WANTED
        names = ", ".join(f"<{name}>" for name in allowed) or "nothing more"
        got = f"<{name}>" + (f" of the namespace {space!r}" if name in allowed else "")
        raise InputError(self.where(), expected=f"{where}: {names}", got=got)

    def _attribute(self, element: str, key: str, attributes: Mapping[str, str]) -> str:
        if not attributes.get(key):
            raise InputError(self.where(), expected=f"<{element} {key}=…>", got=f"no {key}")
        return attributes[key]

    def _number(self, key: str, text: str) -> float:
        stripped = text.strip()
        value = float(stripped) if NUMBER.fullmatch(stripped) else math.nan
        if not math.isfinite(value):
            todo = "write a decimal point" if "," in text else ""
            raise InputError(self.where(), expected=f"a finite number as {key}", got=repr(text), todo=todo)
        return value

    def _read_value(self, attributes: Mapping[str, str]) -> None:
        before, _, line = self.found[self.parameter]
        if not math.isnan(before):
            raise InputError(self.where(), expected=f"one value of {self.parameter!r}", got="another")
        value = self._number("value", self._attribute("Real", "value", attributes))
        self.found[self.parameter] = (value, attributes.get("unit"), line)

    def _read_unit(self, attributes: Mapping[str, str]) -> None:
        if self.unit in self.units:
            raise InputError(self.where(), expected=f"one <BaseUnit> of {self.unit!r}", got="another")
        powers = {base: self._number(base, attributes[base]) for base in BASE if base in attributes}
        factor, offset = (self._number(key, attributes.get(key, d)) for key, d in (("factor", "1"), ("offset", "0")))
        if offset or any(power != int(power) for power in powers.values()):
            expected = "a unit with whole exponents and without offset"
            raise InputError(self.where(), expected=expected, got=repr(self.unit))
        exponents = tuple((base, int(powers[base])) for base in BASE if powers.get(base))
        self.units[self.unit] = Unit(name=self.unit, factor=factor, exponents=exponents)

    def list_parameters(self) -> dict[str, Stated]:
        """Return the parameters with their units, which the file may define below them."""
        return {
            name: Stated(value=value, unit=None if unit is None else self._unit_of(unit, line), line=line)
            for name, (value, unit, line) in self.found.items()
        }

    def _unit_of(self, text: str, line: int) -> Unit:
        if text in self.units:
            return self.units[text]
        try:
            return parse_unit(text)
        except (ValueError, OverflowError):
            where, todo = f"{self.path}, line {line}", "define it below <Units>"
            raise InputError(where, expected="a unit that is known", got=repr(text), todo=todo) from None


def read_ssv(path: Path) -> dict[str, Stated]:
    """Read a parameter set.

    Parameters
    ----------
    path
        File in the format SSV of SSP 1.0.

    Returns
    -------
    dict
        Parameter by name, in the order of the file.

    Raises
    ------
    InputError
        Where the file is no plain XML (a document type is refused), no parameter set of SSP 1.0, states a parameter
        twice, or a value that is no finite real number.
    """
    reader = _Reader(path=str(path))
    parser = reader.parser
    parser.StartDoctypeDeclHandler = reader.refuse_entities
    parser.StartElementHandler, parser.EndElementHandler = reader.begin, reader.end
    try:
        parser.Parse(read_content(path, WANTED), True)
    except expat.ExpatError as error:
        where = f"{path}, line {error.lineno}"
        raise InputError(where, expected=f"XML, {WANTED}", got=expat.ErrorString(error.code)) from None
    except LookupError as error:
        raise InputError(str(path), expected="XML in an encoding that is known", got=str(error)) from None
    return reader.list_parameters()
