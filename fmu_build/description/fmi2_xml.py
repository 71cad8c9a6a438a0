"""The model description of an FMI 2.0 FMU (FMI 2.0.4 standard, section 2.2), written from the interface."""

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
from haptid.model.equations.fmu_names import SENSITIVITY_SWITCH


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

    Raises
    ------
    InputError
        Where ``SOURCE_DATE_EPOCH`` of the environment is no whole number of seconds.
    """
    root = root_of(interface, {"guid": guid}, version="2.0", text=text)
    root.set("numberOfEventIndicators", "0")
    _kinds(root, interface, python)
    variables = add_definitions(root, interface)
    # FMI 2.0 refers to a variable by its place among ModelVariables, from 1
    index = {v.reference: i for i, v in enumerate(interface.variables, start=1)}
    for variable in interface.variables:
        general, real = attributes_of(variable, interface.plain_units)
        if variable.derivative_of is not None:
            real["derivative"] = str(index[variable.derivative_of])
        SubElement(SubElement(variables, "ScalarVariable", general), "Real", real)
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
    _structure(SubElement(root, "ModelStructure"), interface, index)
    return xml_bytes(root)


def _kinds(root: Element, interface: Interface, python: bool) -> None:
    derivatives = "true" if interface.kernel.columns and not python else "false"
    common = {
        "modelIdentifier": interface.identifier,
        "needsExecutionTool": "true" if python else "false",  # it needs a Python interpreter
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
            "canInterpolateInputs": "true",
            "maxOutputDerivativeOrder": "0",
            "canRunAsynchronuously": "false",
        },
    )
    if not python:
        SubElement(SubElement(together, "SourceFiles"), "File", name="all.c")


def _structure(structure: Element, interface: Interface, index: dict[int, int]) -> None:
    uses = Dependencies(interface)
    outputs, derivatives = interface.of_role("output"), interface.of_role("derivative")
    sensitivities = interface.of_role("sensitivity")

    def add(name: str, rows: Iterable[Variable], *, parameters: bool = False) -> None:
        parent = SubElement(structure, name)
        for v in sorted(rows, key=lambda v: index[v.reference]):
            known = (index[r] for r in uses.of(v, parameters=parameters) if r in index)
            add_unknown(parent, "Unknown", {"index": index[v.reference]}, known)

    if outputs or sensitivities:
        add("Outputs", (*outputs, *sensitivities))
    if derivatives:
        add("Derivatives", derivatives)
    if outputs or derivatives:
        add("InitialUnknowns", (*outputs, *derivatives, *sensitivities), parameters=True)
