"""The model description of an FMI 3.0 FMU (FMI 3.0.1 standard, section 2.4), written from the interface."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

from haptid.fmu_build.description.dependencies import Dependencies
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.variables import Variable
from haptid.fmu_build.description.xml_parts import (
    add_definitions,
    add_unknown,
    attributes_of,
    root_of,
    xml_bytes,
)

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

    Raises
    ------
    InputError
        Where ``SOURCE_DATE_EPOCH`` of the environment is no whole number of seconds.
    """
    root = root_of(interface, {"instantiationToken": token}, version="3.0", text=text)
    _kinds(root, interface)
    variables = add_definitions(root, interface, {INDEPENDENT_UNIT})
    _independent(variables, interface)
    for variable in interface.variables:
        general, real = attributes_of(variable, interface.plain_units)
        if variable.derivative_of is not None:
            real["derivative"] = str(variable.derivative_of)
        SubElement(variables, "Float64", general | real)
    _structure(SubElement(root, "ModelStructure"), interface)
    return xml_bytes(root)


def build_description(identifier: str) -> bytes:
    """Return ``sources/buildDescription.xml``: one C99 file that needs no header but the compiler's own.

    Parameters
    ----------
    identifier
        Model identifier.

    Returns
    -------
    bytes
        XML in UTF-8.
    """
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    sources = SubElement(configuration, "SourceFileSet", language="C99")
    SubElement(sources, "SourceFile", name="all.c")
    return xml_bytes(root)


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


def _structure(structure: Element, interface: Interface) -> None:
    uses = Dependencies(interface)
    outputs, derivatives = interface.of_role("output"), interface.of_role("derivative")

    def add(tag: str, rows: Iterable[Variable], *, parameters: bool = False) -> None:
        for v in rows:
            add_unknown(structure, tag, {"valueReference": v.reference}, uses.of(v, parameters=parameters))

    add("Output", outputs)
    add("ContinuousStateDerivative", derivatives)
    add("InitialUnknown", (*outputs, *derivatives), parameters=True)
