"""What a search for missing effects is asked for: `Job`, with the catalogue that it searches."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.fmu_build.building.packaging import Kind
from haptid.measurement.values.campaign import Campaign
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import with_folder
from haptid.support.errors import InputError

MOST_STARTS, MOST_EFFORT = 8, THRESHOLDS.study.most_simulated_runs
"""Defaults of a search: starts of the nominal fit, and simulated runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """Inputs of one search.

    Parameters
    ----------
    campaign
        Campaign that is ready for fits.
    catalogue
        Effects that are searched for, by key.
    out
        Folder of the results, perhaps with those of an identification.
    kind
        Packaging of the FMU with the named effects.
    seed, starts
        Seed and most starts of the nominal fit.
    effort
        Simulated runs after which no further combinations of effects are tried.
    threads
        Threads that simulate runs side by side; the result does not depend on their number.
    """

    campaign: Campaign
    catalogue: Mapping[str, Effect]
    out: Path
    kind: Kind = "python"
    seed: int = 0
    starts: int = MOST_STARTS
    effort: int = MOST_EFFORT
    threads: int = 1


def catalogue_without(left_out: Collection[str], folder: Path | None = None) -> dict[str, Effect]:
    """Return the catalogue, and the user's own effects, without some.

    Parameters
    ----------
    left_out
        Ids or keys of the effects to leave out.
    folder
        Folder with effects of the user's own; None for none.

    Returns
    -------
    dict
        Effects by key.

    Raises
    ------
    InputError
        Where there is no such id, or a file of the folder is at fault.
    """
    every = with_folder(folder)
    unknown = set(left_out) - {name for key, effect in every.items() for name in (key, effect.id)}
    if unknown:
        raise InputError("--without", expected="ids of the catalogue", got=", ".join(sorted(unknown)))
    return {key: effect for key, effect in every.items() if not {key, effect.id} & set(left_out)}
