"""Results of other data that lie in a folder: its path and the data of a new identification in, their names out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from haptid.fmu_build.accuracy.stored_draws import POSTERIOR
from haptid.fmu_build.exchange.identification_json import read_identification
from haptid.identification.sequence.carried_fit import FILE
from haptid.report.common.linked_pages import FINDINGS, NAME_OF_FINDING
from haptid.support.errors import InputError


def findings_below(folder: Path) -> dict[str, Path]:
    """Return the findings below a folder of results.

    Parameters
    ----------
    folder
        Folder of the identification.

    Returns
    -------
    dict
        File by name, as ``joint4``.
    """
    files = sorted((folder / FINDINGS).glob("*.json"))
    return {path.stem: path for path in files if NAME_OF_FINDING.fullmatch(path.stem)}


def later_results(folder: Path) -> tuple[str, ...]:
    """Return the posteriors and findings that lie beside an identification.

    Parameters
    ----------
    folder
        Folder of the identification.

    Returns
    -------
    tuple of str
        Their paths below the folder.
    """
    files = (folder / POSTERIOR, *findings_below(folder).values())
    return tuple(path.relative_to(folder).as_posix() for path in files if path.is_file())


def of_other_data(folder: Path, title: str, digests: Mapping[tuple[int, ...], frozenset[str]]) -> tuple[str, ...]:
    """Return the posteriors and findings that a new identification would leave beside it, of other data than its own.

    Parameters
    ----------
    folder
        Folder of the new identification, before it is written.
    title
        Title of its campaign.
    digests
        Digests of the data of each set of free joints that it fits.

    Returns
    -------
    tuple of str
        Paths below the folder; none where the identification there is of the same campaign, and no joint that is
        fitted again has other runs or entries.
    """
    try:
        there = read_identification(folder / FILE)
    except InputError:  # none that could be read: nothing is known of what lies beside it
        return ()
    fitted = ((tuple(entry["free_joints"]), entry.get("data")) for entry in there["configurations"])
    changed = any(joints in digests and digest not in digests[joints] for joints, digest in fitted)
    return later_results(folder) if changed or there["campaign"] != title else ()
