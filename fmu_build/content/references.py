"""What the files of an FMU are for, after FMI-LS-REF: names of files in, ``fmi-ls-manifest.xml`` out.

The layered standard (https://modelica.github.io/fmi-ls-ref/main, 1.0.0-alpha.1) lets a tool that knows nothing of
haptid find the parameter set, the draws, the reports and the reference run of an FMU by their roles.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from xml.etree.ElementTree import Element, SubElement, register_namespace

from haptid.fmu_build.content.accuracy_files import FOLDER
from haptid.fmu_build.description.xml_parts import xml_bytes

NAME = "org.fmi-standard.fmi-ls-ref"
MANIFEST = f"extra/{NAME}/fmi-ls-manifest.xml"
"""Place of the manifest within the archive."""
PARAMETER_SET = "resources/parameters.ssv"
"""Place of the parameter set within the archive."""
VERSION = "1.0.0-alpha.1"
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
ABOUT = "Layered Standard providing information on related files included in an FMU."
"""Description of the standard that its schema fixes."""
CSV, JSON, SSV = "text/csv", "application/json", "application/x-ssp-parameter-set"
ROLES = (
    ("documentation/index.html", "document", "text/html", "What the model is, its variables, and how good it is"),
    (PARAMETER_SET, "parameter", SSV, "Parameter set that the FMU starts with"),
    (f"{FOLDER}/draws.csv", "parameter", CSV, "Draws of the parameters, one set a row"),
    (f"{FOLDER}/parameters.csv", "report", CSV, "Mean, standard deviation and quantiles of the parameters"),
    (f"{FOLDER}/correlation.csv", "report", CSV, "Correlation of the parameters"),
    (f"{FOLDER}/verification.json", "report", JSON, "What the model leaves of recorded runs, joint by joint"),
    (f"{FOLDER}/effects.json", "report", JSON, "Effects that a search named, with what each closes"),
    (f"{FOLDER}/digests.json", "meta-data", JSON, "Digests of the equations, the campaign and the code"),
    ("documentation/*_in.csv", "testcase", CSV, "Inputs of the reference run"),
    ("documentation/*_ref.csv", "result", CSV, "Outputs of the reference run"),
)
"""Files by pattern: role of the standard, MIME type and description."""


def manifest_file(names: Iterable[str]) -> dict[str, bytes]:
    """Return the manifest of the files of an archive.

    Parameters
    ----------
    names
        Names within the archive; those without a role are left out.

    Returns
    -------
    dict
        The manifest by its name within the archive.
    """
    register_namespace("fmi-ls", NAMESPACE)
    told = {"fmi-ls-name": NAME, "fmi-ls-version": VERSION, "fmi-ls-description": ABOUT}
    root = Element("fmiReferences", {f"{{{NAMESPACE}}}{key}": value for key, value in told.items()})
    for name, role, kind, description in _references_of(sorted(names)):
        # relative to the manifest, two folders below the root of the archive
        SubElement(root, "Related", type=kind, source=f"../../{name}", role=role, description=description)
    return {MANIFEST: xml_bytes(root)}


def _references_of(names: Iterable[str]) -> Iterator[tuple[str, str, str, str]]:
    for name in names:
        for pattern, role, kind, description in ROLES:
            if fnmatchcase(name, pattern):
                yield name, role, kind, description
