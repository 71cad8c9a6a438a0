"""Files of an FMU beside its code: `Interface` in; page, licences, parameter set, picture, runs, manifest out."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping
from importlib import resources

from haptid.fmu_build.accuracy.accuracy import FIRST_GUESSES, Accuracy
from haptid.fmu_build.content.accuracy_files import accuracy_files
from haptid.fmu_build.content.documentation import documentation
from haptid.fmu_build.content.picture import picture
from haptid.fmu_build.content.reference_run import reference
from haptid.fmu_build.content.references import PARAMETER_SET, manifest_file
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.provenance import Provenance, provenance_of
from haptid.fmu_build.description.units import modelica_unit
from haptid.fmu_build.exchange.ssv import ssv_bytes


def extra_files(
    interface: Interface,
    *,
    text: str,
    python: bool,
    linear: bool,
    provenance: Mapping[str, Provenance | str],
    accuracy: Accuracy = FIRST_GUESSES,
) -> dict[str, bytes]:
    """Build the files of an FMU that hold no code.

    Parameters
    ----------
    interface
        Variables and kernel of the FMU.
    text
        Description of the model, one line.
    python
        Whether the archive holds pythonfmu, whose licence it then carries.
    linear
        Whether a host may set the derivatives of the inputs.
    provenance
        Known provenance of parameters by id.
    accuracy
        How good the values are, for page and files.

    Returns
    -------
    dict
        Content by name within the archive. An identification FMU, and one that cannot run on this machine, has no
        reference run and no picture; the former says nothing of its accuracy, as a fit sets its values.

    Raises
    ------
    OverflowingError
        Where the reference run gives no finite numbers.
    """
    origins = provenance_of(interface.equations, provenance)
    licence = resources.files("haptid.fmu_build.content") / "license.txt"
    page = documentation(interface, text=text, linear=linear, source=not python, provenance=origins, accuracy=accuracy)
    files = {
        "documentation/index.html": page.encode(),
        "documentation/licenses/license.txt": licence.read_bytes(),
        PARAMETER_SET: _parameter_set(interface),
    }
    if not interface.identification:
        files |= accuracy_files(interface, accuracy, origins)
    if python:
        files["documentation/licenses/pythonfmu.txt"] = _licence_of("pythonfmu")
    run = None if interface.identification else reference(interface)
    if run is not None:
        files |= {f"documentation/{name}": data for name, data in run.files().items()}
        files["model.png"] = picture(run.t, run.y[:, 0])
    return files | manifest_file(files)


def _parameter_set(interface: Interface) -> bytes:
    parameters = interface.of_role("parameter")
    values = {v.name: v.start for v in parameters if v.start is not None}
    return ssv_bytes(values, {v.name: modelica_unit(v.unit) for v in parameters})


def _licence_of(distribution: str) -> bytes:
    """Return the licence text that an installed distribution carries."""
    found = importlib.metadata.files(distribution) or []
    for entry in found:
        if entry.name.upper().startswith("LICEN"):
            return entry.read_binary()
    return f"{distribution}: see https://pypi.org/project/{distribution}/\n".encode()
