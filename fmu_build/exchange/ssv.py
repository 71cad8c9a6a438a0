"""Parameter sets of the standard SSP: values and units by variable name in, SSV file out (SSP 1.0, section 6)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from haptid.fmu_build.description.units import parse_unit
from haptid.fmu_build.description.xml_parts import xml_bytes
from haptid.support.files.files import write_bytes

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"


def ssv_bytes(
    values: Mapping[str, float], units: Mapping[str, str] | None = None, *, name: str = "parameters"
) -> bytes:
    """Return a parameter set of real values.

    Parameters
    ----------
    values
        Value by variable name.
    units
        Unit by variable name, as `parse_unit` reads it; 1 where absent. None is written where it is empty: the value
        is then in the variable's own unit.
    name
        Name of the set.

    Returns
    -------
    bytes
        Indented XML in UTF-8 with definitions of the units; numbers keep their last bit.

    Raises
    ------
    ValueError
        Where a unit is unknown.
    """
    ElementTree.register_namespace("ssv", SSV)
    ElementTree.register_namespace("ssc", SSC)
    of = dict(units or {})
    root = Element(f"{{{SSV}}}ParameterSet", version="1.0", name=name)
    parameters = SubElement(root, f"{{{SSV}}}Parameters")
    for variable, value in values.items():
        node = SubElement(parameters, f"{{{SSV}}}Parameter", name=variable)
        unit = of.get(variable, "1")
        SubElement(node, f"{{{SSV}}}Real", {"value": repr(float(value)), **({"unit": unit} if unit else {})})
    define_units(root, f"{{{SSV}}}Units", {of.get(variable, "1") for variable in values} - {""})
    return xml_bytes(root)


def define_units(root: Element, tag: str, units: Iterable[str]) -> None:
    """Add the definitions of units to a document of SSP, which must define every unit that it names.

    Parameters
    ----------
    root
        Element to which they are added.
    tag
        Name of the element that holds them.
    units
        Units as `parse_unit` reads them; nothing is added where there are none.

    Raises
    ------
    ValueError
        Where a unit is unknown.
    """
    named = sorted(set(units))
    if not named:
        return
    definitions = SubElement(root, tag)
    for text in named:
        unit = parse_unit(text)
        exponents = {base: str(n) for base, n in unit.exponents}
        node = SubElement(definitions, f"{{{SSC}}}Unit", name=text)
        SubElement(node, f"{{{SSC}}}BaseUnit", exponents | ({} if unit.factor == 1 else {"factor": repr(unit.factor)}))


def write_ssv(
    path: Path, values: Mapping[str, float], units: Mapping[str, str] | None = None, *, name: str = "parameters"
) -> Path:
    """Write a parameter set of real values, see `ssv_bytes`.

    Parameters
    ----------
    path
        File to write.
    values
        Value by variable name.
    units
        Unit by variable name; 1 where absent.
    name
        Name of the set.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    ValueError
        Where a unit is unknown.
    InputError, WritingError
        As `write_bytes`.
    """
    return write_bytes(path, ssv_bytes(values, units, name=name))
