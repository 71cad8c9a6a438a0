"""The model description of an FMI 2.0 FMU (FMI 2.0.4 standard, section 2.2), written from the interface."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import sympy as sp

from fmu_build.units import BASE, parse_unit
from fmu_build.variables import SENSITIVITY_SWITCH, Interface, Variable

LOG_CATEGORIES = (("logStatusError", "Values and calls that are refused, with what was expected"),)
TOOL = "haptid 0.1"
LICENCE = "BSD-3-Clause"


def model_description(interface: Interface, *, guid: str, python: bool, text: str) -> bytes:
    """Return ``modelDescription.xml``.

    Parameters
    ----------
    guid
        Identity of the content.
    python
        Whether this is the Python packaging: co-simulation alone, no directional derivatives.
    text
        Description of the model.
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=interface.identifier,
        guid=guid,
        description=text,
        license=LICENCE,
        generationTool=TOOL,
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    _kinds(root, interface, python)
    _units(root, {v.unit for v in interface.variables})
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES:
        SubElement(categories, "Category", name=name, description=meaning)
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=_number(interface.kernel.step))
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


def _number(value: float) -> str:
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


def _units(root: Element, names: Iterable[str]) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted(names):
        unit = parse_unit(name)
        node = SubElement(definitions, "Unit", name=name)
        exponents = dict(unit.exponents)
        attributes = {base: str(exponents[base]) for base in BASE if base in exponents}
        if unit.factor != 1.0:
            attributes["factor"] = _number(unit.factor)
        SubElement(node, "BaseUnit", attributes)
        if unit.display:
            SubElement(node, "DisplayUnit", name=unit.display[0], factor=_number(unit.display[1]))


def _scalar(parent: Element, v: Variable, interface: Interface) -> None:
    attributes = {
        "name": v.name,
        "valueReference": str(v.reference),
        "description": v.description,
        "causality": v.causality,
        "variability": v.variability,
    }
    if v.initial:
        attributes["initial"] = v.initial
    node = SubElement(parent, "ScalarVariable", attributes)
    real = {"unit": v.unit}
    display = parse_unit(v.unit).display
    if display:
        real["displayUnit"] = display[0]
    for key, value in (("min", v.minimum), ("max", v.maximum)):
        if math.isfinite(value):
            real[key] = _number(value)
    real["nominal"] = _number(v.nominal)
    if v.start is not None:
        real["start"] = _number(v.start)
    if v.derivative_of is not None:
        real["derivative"] = str(_index(interface, v.derivative_of))
    SubElement(node, "Real", real)


def _index(interface: Interface, reference: int) -> int:
    return next(i for i, v in enumerate(interface.variables, start=1) if v.reference == reference)


def _structure(root: Element, interface: Interface) -> None:
    structure = SubElement(root, "ModelStructure")
    index = {v.reference: i for i, v in enumerate(interface.variables, start=1)}
    uses = Uses(interface)
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
    parent: Element, rows: Iterable[Variable], index: dict[int, int], uses: Uses, *, parameters: bool
) -> None:
    for v in sorted(rows, key=lambda v: index[v.reference]):
        known = sorted(index[r] for r in uses.of(v, parameters=parameters) if r in index)
        attributes = {"index": str(index[v.reference]), "dependencies": " ".join(map(str, known))}
        if known:
            attributes["dependenciesKind"] = " ".join(["dependent"] * len(known))
        SubElement(parent, "Unknown", attributes)


class Uses:
    """On which variables each output and derivative depends, read off the formulas."""

    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        e = interface.equations
        self._definitions = {s: sp.sympify(f).free_symbols for s, f in e.definitions}
        self._resolved: dict[sp.Symbol, set[sp.Symbol]] = {}
        for symbol, used in self._definitions.items():
            self._resolved[symbol] = self._resolve(used)
        self._references = {v.id: v for v in interface.variables if v.settable}
        matrix = [entry for row in e.mass_matrix or () for entry in row]
        self._matrix = self._resolve(set().union(*(sp.sympify(f).free_symbols for f in matrix), set()))

    def _resolve(self, symbols: set[sp.Symbol]) -> set[sp.Symbol]:
        return set().union(*(self._resolved.get(s, {s}) for s in symbols), set())

    def of(self, v: Variable, *, parameters: bool) -> set[int]:
        """Return the references on which ``v`` depends; of parameters only where asked."""
        names = {s.name for s in self._symbols(v)}
        return {
            r.reference for id, r in self._references.items() if id in names and (parameters or r.role != "parameter")
        }

    def _symbols(self, v: Variable) -> set[sp.Symbol]:
        e, n = self.interface.equations, len(self.interface.equations.joints)
        if v.role == "output":
            expression = next(o.expression for o in e.outputs if o.id == v.id)
            return self._resolve(sp.sympify(expression).free_symbols)
        if v.role == "derivative":
            i = v.reference - self.interface.offsets["dx"]
            if e.mass_matrix is None or not n <= i < 2 * n:
                return self._resolve(sp.sympify(e.rhs[i]).free_symbols)
            rows = set().union(*(sp.sympify(f).free_symbols for f in e.rhs[n : 2 * n]))
            return self._resolve(rows) | self._matrix
        return {q.symbol for quantities in (e.states, e.inputs, e.parameters) for q in quantities}
