"""The model description of an FMI 2.0 FMU (FMI 2.0.4 standard, section 2.2), written from the interface."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from haptid.fmu_build.description.dependencies import Dependencies
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.units import BASE, parse_unit
from haptid.fmu_build.description.variables import Variable
from haptid.model.equations.fmu_names import SENSITIVITY_SWITCH
from haptid.support.errors import one_line

LOG_CATEGORIES = (("logStatusError", "Values and calls that are refused, with what was expected"),)
TOOL = "haptid 0.1"
LICENCE = "BSD-3-Clause"


def model_description(interface: Interface, *, guid: str, python: bool, text: str) -> bytes:
    """Return ``modelDescription.xml`` of FMI 2.0.

    Parameters
    ----------
    interface
        Variables, kernel and identifier of the FMU.
    guid
        Identity of the content (`guid_of`), the same as in the binary.
    python
        Whether this is the Python packaging: co-simulation alone, no directional derivatives.
    text
        Description of the model, one line.

    Returns
    -------
    bytes
        Indented XML in UTF-8.
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=interface.identifier,
        guid=guid,
        description=one_line(text),
        license=LICENCE,
        generationTool=TOOL,
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    _kinds(root, interface, python)
    unit_definitions(root, {v.unit for v in interface.variables if v.unit})
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES:
        SubElement(categories, "Category", name=name, description=meaning)
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=number(interface.kernel.step))
    variables = SubElement(root, "ModelVariables")
    for variable in interface.variables:
        _scalar(variables, variable, interface)
    if interface.identification:
        switch = SubElement(
            variables,
            "ScalarVariable",
            name=SENSITIVITY_SWITCH,
            valueReference=str(interface.offsets["end"]),
            causality="parameter",
            variability="fixed",
            initial="exact",
            description="whether the sensitivities are computed",
        )
        SubElement(switch, "Boolean", start="false")
    _structure(root, interface)
    ElementTree.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="utf-8") + b"\n"


def number(value: float) -> str:
    """Return the shortest text that reads back as ``value``."""
    return repr(float(value))


def _kinds(root: Element, interface: Interface, python: bool) -> None:
    derivatives = "true" if interface.kernel.columns and not python else "false"
    common = {
        "modelIdentifier": interface.identifier,
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "false",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": derivatives,
    }
    if not python:
        exchange = SubElement(root, "ModelExchange", {**common, "completedIntegratorStepNotNeeded": "true"})
        SubElement(SubElement(exchange, "SourceFiles"), "File", name="all.c")
    together = SubElement(
        root,
        "CoSimulation",
        {
            **common,
            "canHandleVariableCommunicationStepSize": "true",
            "canInterpolateInputs": "false" if python else "true",
            "maxOutputDerivativeOrder": "0",
            "canRunAsynchronuously": "false",
        },
    )
    if not python:
        SubElement(SubElement(together, "SourceFiles"), "File", name="all.c")


def unit_definitions(root: Element, names: Iterable[str]) -> None:
    """Append ``UnitDefinitions``, which FMI 2.0 and 3.0 write alike, to an element.

    Parameters
    ----------
    root
        Element that gets the definitions.
    names
        Units as `parse_unit` reads them; each is written with SI exponents, factor and display unit.

    Raises
    ------
    ValueError
        Where a unit is unknown.
    """
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted(names):
        unit = parse_unit(name)
        node = SubElement(definitions, "Unit", name=name)
        exponents = dict(unit.exponents)
        attributes = {base: str(exponents[base]) for base in BASE if base in exponents}
        if unit.factor != 1.0:
            attributes["factor"] = number(unit.factor)
        SubElement(node, "BaseUnit", attributes)
        if unit.display:
            SubElement(node, "DisplayUnit", name=unit.display[0], factor=number(unit.display[1]))


def _scalar(parent: Element, v: Variable, interface: Interface) -> None:
    attributes = {
        "name": v.name,
        "valueReference": str(v.reference),
        "description": one_line(v.description),
        "causality": v.causality,
        "variability": v.variability,
    }
    if v.initial:
        attributes["initial"] = v.initial
    node = SubElement(parent, "ScalarVariable", attributes)
    real = {"unit": v.unit} if v.unit else {}
    display = parse_unit(v.unit).display if v.unit else None
    if display:
        real["displayUnit"] = display[0]
    for key, value in (("min", v.minimum), ("max", v.maximum)):
        if math.isfinite(value):
            real[key] = number(value)
    real["nominal"] = number(v.nominal)
    if v.start is not None:
        real["start"] = number(v.start)
    if v.derivative_of is not None:
        real["derivative"] = str(_index(interface, v.derivative_of))
    SubElement(node, "Real", real)


def _index(interface: Interface, reference: int) -> int:
    """Return the place of a variable among ``ModelVariables`` from 1, by which FMI 2.0 refers to it."""
    return next(i for i, v in enumerate(interface.variables, start=1) if v.reference == reference)


def _structure(root: Element, interface: Interface) -> None:
    structure = SubElement(root, "ModelStructure")
    index = {v.reference: i for i, v in enumerate(interface.variables, start=1)}
    uses = Dependencies(interface)
    outputs, derivatives = interface.of_role("output"), interface.of_role("derivative")
    sensitivities = interface.of_role("sensitivity")
    for name, rows in (("Outputs", (*outputs, *sensitivities)), ("Derivatives", derivatives)):
        if rows:
            _unknowns(SubElement(structure, name), rows, index, uses, parameters=False)
    if outputs or derivatives:
        _unknowns(
            SubElement(structure, "InitialUnknowns"),
            (*outputs, *derivatives, *sensitivities),
            index,
            uses,
            parameters=True,
        )


def _unknowns(
    parent: Element, rows: Iterable[Variable], index: dict[int, int], uses: Dependencies, *, parameters: bool
) -> None:
    for v in sorted(rows, key=lambda v: index[v.reference]):
        known = sorted(index[r] for r in uses.of(v, parameters=parameters) if r in index)
        attributes = {"index": str(index[v.reference]), "dependencies": " ".join(map(str, known))}
        if known:
            attributes["dependenciesKind"] = " ".join(["dependent"] * len(known))
        SubElement(parent, "Unknown", attributes)
