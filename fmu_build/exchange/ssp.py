"""Systems of FMUs: FMU files and their connections in, an SSP archive out (SSP 1.0, section 5)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import fmpy

from haptid.fmu_build.description.xml_parts import xml_bytes
from haptid.fmu_build.exchange.archive import pack
from haptid.fmu_build.exchange.ssv import SSC, SSV, define_units, ssv_bytes
from haptid.support.files.files import write_bytes

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
KINDS = {"input": "input", "output": "output", "parameter": "parameter"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """Connect an output of one component to an input of another.

    Parameters
    ----------
    from_component, from_variable
        Component and its output.
    to_component, to_variable
        Component and its input that takes the value.
    """

    from_component: str
    from_variable: str
    to_component: str
    to_variable: str


def write_ssp(
    path: Path,
    fmus: Mapping[str, Path],
    connections: Sequence[Connection],
    *,
    parameters: Mapping[str, Mapping[str, float]] | None = None,
    stop_time: float = 10.0,
    name: str = "system",
) -> Path:
    """Write a system of co-simulated FMUs.

    Parameters
    ----------
    path
        Archive to write (``.ssp``).
    fmus
        The FMU of each component by the component's name; FMI 2.0, as only variables of type Real are listed.
    connections
        Outputs to inputs.
    parameters
        Values by component and variable, in the units of the FMU.
    stop_time
        End of the default experiment [s].
    name
        Name of the system.

    Returns
    -------
    Path
        ``path``.
    """
    ElementTree.register_namespace("ssd", SSD)
    ElementTree.register_namespace("ssc", SSC)
    ElementTree.register_namespace("ssv", SSV)
    root = Element(f"{{{SSD}}}SystemStructureDescription", version="1.0", name=name)
    system = SubElement(root, f"{{{SSD}}}System", name=name)
    elements = SubElement(system, f"{{{SSD}}}Elements")
    files = {}
    for component, fmu in fmus.items():
        files[f"resources/{component}.fmu"] = fmu.read_bytes()
        values = dict((parameters or {}).get(component, {}))
        if values:
            files[f"resources/{component}.ssv"] = ssv_bytes(values, _units(fmu))
        _component(elements, component, fmu, with_values=bool(values))
    # The schema has no empty list of connections.
    wires = SubElement(system, f"{{{SSD}}}Connections") if connections else system
    for c in connections:
        SubElement(
            wires,
            f"{{{SSD}}}Connection",
            startElement=c.from_component,
            startConnector=c.from_variable,
            endElement=c.to_component,
            endConnector=c.to_variable,
        )
    define_units(root, f"{{{SSD}}}Units", {node.get("unit", "") for node in system.iter(f"{{{SSC}}}Real")} - {""})
    SubElement(root, f"{{{SSD}}}DefaultExperiment", startTime="0.0", stopTime=repr(stop_time))
    return write_bytes(path, pack({"SystemStructure.ssd": xml_bytes(root), **files}))


def _units(fmu: Path) -> dict[str, str]:
    return {v.name: v.unit for v in fmpy.read_model_description(str(fmu)).modelVariables if v.unit}


def _component(elements: Element, name: str, fmu: Path, *, with_values: bool) -> None:
    node = SubElement(
        elements,
        f"{{{SSD}}}Component",
        name=name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{name}.fmu",
    )
    connectors = SubElement(node, f"{{{SSD}}}Connectors")
    for v in fmpy.read_model_description(str(fmu)).modelVariables:
        if v.causality in KINDS and v.type == "Real":
            connector = SubElement(connectors, f"{{{SSD}}}Connector", name=v.name, kind=KINDS[v.causality])
            SubElement(connector, f"{{{SSC}}}Real", {"unit": v.unit} if v.unit else {})
    if with_values:
        bindings = SubElement(node, f"{{{SSD}}}ParameterBindings")
        SubElement(bindings, f"{{{SSD}}}ParameterBinding", source=f"resources/{name}.ssv")
