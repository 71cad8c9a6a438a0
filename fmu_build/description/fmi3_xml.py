"""The model description of an FMI 3.0 FMU (FMI 3.0.1 standard, section 2.4), written from the interface."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from haptid.fmu_build.description.dependencies import Dependencies
from haptid.fmu_build.description.fmi2_xml import LICENCE, LOG_CATEGORIES, TOOL, number, unit_definitions
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.units import parse_unit
from haptid.fmu_build.description.variables import Variable

INDEPENDENT, INDEPENDENT_UNIT = "time", "s"


def model_description3(interface: Interface, *, token: str, text: str) -> bytes:
    """Return ``modelDescription.xml`` of FMI 3.0: the native packaging, co-simulation and model exchange.

    Parameters
    ----------
    interface
        Variables, kernel and identifier of the FMU.
    token
        Instantiation token: identity of the content (`guid_of`), the same as in the binary.
    text
        Description of the model, one line.

    Returns
    -------
    bytes
        Indented XML in UTF-8.
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=interface.identifier,
        instantiationToken=token,
        description=text,
        license=LICENCE,
        generationTool=TOOL,
        variableNamingConvention="structured",
    )
    _kinds(root, interface)
    unit_definitions(root, {v.unit for v in interface.variables if v.unit} | {INDEPENDENT_UNIT})
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES:
        SubElement(categories, "Category", name=name, description=meaning)
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=number(interface.kernel.step))
    variables = SubElement(root, "ModelVariables")
    _independent(variables, interface)
    for variable in interface.variables:
        SubElement(variables, "Float64", _attributes(variable))
    _structure(SubElement(root, "ModelStructure"), interface)
    ElementTree.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="utf-8") + b"\n"


def build_description(identifier: str) -> bytes:
    """Return ``sources/buildDescription.xml``: one C99 file that needs no header but the compiler's own."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    sources = SubElement(configuration, "SourceFileSet", language="C99")
    SubElement(sources, "SourceFile", name="all.c")
    ElementTree.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="utf-8") + b"\n"


def _kinds(root: Element, interface: Interface) -> None:
    derivatives = "true" if interface.kernel.columns else "false"
    common = {
        "modelIdentifier": interface.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": derivatives,
        "providesAdjointDerivatives": derivatives,
    }
    SubElement(root, "ModelExchange", common)
    SubElement(root, "CoSimulation", {**common, "canHandleVariableCommunicationStepSize": "true"})


def _independent(parent: Element, interface: Interface) -> None:
    SubElement(
        parent,
        "Float64",
        name=INDEPENDENT,
        valueReference=str(interface.offsets["end"]),
        causality="independent",
        variability="continuous",
        description="simulation time",
        unit=INDEPENDENT_UNIT,
    )


def _attributes(v: Variable) -> dict[str, str]:
    attributes = {
        "name": v.name,
        "valueReference": str(v.reference),
        "description": v.description,
        "causality": v.causality,
        "variability": v.variability,
        "initial": v.initial,
        "unit": v.unit,
    }
    display = parse_unit(v.unit).display if v.unit else None
    if display:
        attributes["displayUnit"] = display[0]
    numbers = {"min": v.minimum, "max": v.maximum, "nominal": v.nominal, "start": v.start}
    attributes |= {key: number(x) for key, x in numbers.items() if x is not None and math.isfinite(x)}
    if v.derivative_of is not None:
        attributes["derivative"] = str(v.derivative_of)
    return {key: value for key, value in attributes.items() if value}


def _structure(structure: Element, interface: Interface) -> None:
    uses = Dependencies(interface)
    outputs, derivatives = interface.of_role("output"), interface.of_role("derivative")
    _unknowns(structure, "Output", outputs, uses, parameters=False)
    _unknowns(structure, "ContinuousStateDerivative", derivatives, uses, parameters=False)
    _unknowns(structure, "InitialUnknown", (*outputs, *derivatives), uses, parameters=True)


def _unknowns(parent: Element, tag: str, rows: Iterable[Variable], uses: Dependencies, *, parameters: bool) -> None:
    for v in rows:
        known = sorted(uses.of(v, parameters=parameters))
        attributes = {"valueReference": str(v.reference), "dependencies": " ".join(map(str, known))}
        if known:
            attributes["dependenciesKind"] = " ".join(["dependent"] * len(known))
        SubElement(parent, tag, attributes)
