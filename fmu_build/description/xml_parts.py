"""What the model descriptions of FMI 2.0 and 3.0 have in common: `Interface` in, XML elements and bytes out."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable
from datetime import UTC, datetime
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.units import BASE, modelica_unit, parse_unit
from haptid.fmu_build.description.variables import Variable
from haptid.support.errors import InputError, one_line

LOG_CATEGORIES = (
    ("logStatusError", "Values and calls that are refused, with what was expected"),
    ("logStatusDiscard", "Steps that failed, with what made them fail, and statuses that there are not"),
)
TOOL = "haptid 0.1"
LICENCE = "BSD-3-Clause"
AUTHOR, COPYRIGHT = "haptid", "Copyright (c) 2026, the haptid authors"
EPOCH_S = int(datetime(1980, 1, 1, tzinfo=UTC).timestamp())
"""Date of all entries of an archive, and of its generation where the environment does not say another one."""


def xml_bytes(root: Element) -> bytes:
    """Return the document of an element: indented XML in UTF-8.

    Parameters
    ----------
    root
        Root element; its children are indented in place.

    Returns
    -------
    bytes
        XML with declaration and a newline at its end.
    """
    ElementTree.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="utf-8") + b"\n"


def generation_date() -> str:
    """Return the date that a model description states, in UTC.

    Returns
    -------
    str
        That of ``SOURCE_DATE_EPOCH`` [s since 1970] (reproducible-builds.org), else that of the archive's entries: the
        same equations and values must give the same bytes.

    Raises
    ------
    InputError
        Where the variable holds no whole number of seconds.
    """
    stated = os.environ.get("SOURCE_DATE_EPOCH", str(EPOCH_S))
    try:
        return datetime.fromtimestamp(int(stated), UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    except (ValueError, OverflowError, OSError):
        raise InputError("SOURCE_DATE_EPOCH", expected="whole seconds since 1970", got=repr(stated)) from None


def root_of(interface: Interface, identity: dict[str, str], *, version: str, text: str) -> Element:
    """Return the root of a model description with its attributes.

    Parameters
    ----------
    interface
        Interface of the FMU.
    identity
        The attribute that holds the FMU's identity.
    version
        Version of FMI.
    text
        Description of the model, one line.

    Returns
    -------
    Element

    Raises
    ------
    InputError
        Where ``SOURCE_DATE_EPOCH`` of the environment is no whole number of seconds.
    """
    return Element(
        "fmiModelDescription",
        {"fmiVersion": version, "modelName": interface.identifier}
        | identity
        | {
            "description": one_line(text),
            "author": AUTHOR,
            "version": interface.equations.digest,
            "copyright": COPYRIGHT,
            "license": LICENCE,
            "generationTool": TOOL,
            "generationDateAndTime": generation_date(),
            "variableNamingConvention": "structured",
        },
    )


def add_definitions(root: Element, interface: Interface, units: Iterable[str] = ()) -> Element:
    """Append what stands between the kinds of an FMU and its variables.

    Parameters
    ----------
    root
        Model description.
    interface
        Interface of the FMU.
    units
        Units beside those of the interface's variables.

    Returns
    -------
    Element
        ``ModelVariables``, still empty.
    """
    names = {v.unit for v in interface.variables if v.unit}.union(units)
    add_unit_definitions(root, names, interface.plain_units)
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES:
        SubElement(categories, "Category", name=name, description=meaning)
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=_number(interface.kernel.step))
    return SubElement(root, "ModelVariables")


def add_unit_definitions(root: Element, names: Iterable[str], plain: Collection[str] = ()) -> None:
    """Append ``UnitDefinitions`` to an element.

    Parameters
    ----------
    root
        Element that gets the definitions.
    names
        Units as `parse_unit` reads them; each is written with SI exponents, factor and display unit.
    plain
        Units that get no display unit.

    Raises
    ------
    ValueError
        Where a unit is unknown.
    """
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted(names):
        unit = parse_unit(name)
        node = SubElement(definitions, "Unit", name=modelica_unit(name))
        exponents = dict(unit.exponents)
        attributes = {base: str(exponents[base]) for base in BASE if base in exponents}
        if unit.factor != 1.0:
            attributes["factor"] = _number(unit.factor)
        SubElement(node, "BaseUnit", attributes)
        if unit.display and name not in plain:
            SubElement(node, "DisplayUnit", name=modelica_unit(unit.display[0]), factor=_number(unit.display[1]))


def attributes_of(v: Variable, plain: Collection[str] = ()) -> tuple[dict[str, str], dict[str, str]]:
    """Return the attributes of a variable but ``derivative``, to which each version of FMI refers in its own way.

    Parameters
    ----------
    v
        Variable.
    plain
        Units that get no display unit.

    Returns
    -------
    general, real
        Attributes of every variable, and of a real one, each in the order of the standards' schemas.
    """
    general = {
        "name": v.name,
        "valueReference": str(v.reference),
        "description": one_line(v.description),
        "causality": v.causality,
        "variability": v.variability,
        "initial": v.initial,
    }
    display = parse_unit(v.unit).display if v.unit and v.unit not in plain else None
    real = {"unit": modelica_unit(v.unit), "displayUnit": modelica_unit(display[0]) if display else ""}
    numbers = {"min": v.minimum, "max": v.maximum, "nominal": v.nominal, "start": v.start}
    real |= {key: _number(x) for key, x in numbers.items() if x is not None and math.isfinite(x)}
    return {key: value for key, value in general.items() if value}, {key: value for key, value in real.items() if value}


def add_unknown(parent: Element, tag: str, place: dict[str, int], known: Iterable[int]) -> None:
    """Append an unknown of the model structure.

    Parameters
    ----------
    parent, tag
        Element that gets the unknown, and its tag.
    place
        Attribute by which this version of FMI refers to the unknown.
    known
        What the unknown depends on, referred to in the same way.
    """
    names = [str(number) for number in sorted(known)]
    attributes = {key: str(number) for key, number in place.items()} | {"dependencies": " ".join(names)}
    if names:
        attributes["dependenciesKind"] = " ".join(["dependent"] * len(names))
    SubElement(parent, tag, attributes)


def _number(value: float) -> str:
    """Return the shortest text that reads back as ``value``."""
    return repr(float(value))
