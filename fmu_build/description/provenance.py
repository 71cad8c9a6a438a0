"""Provenance of the parameter values in an FMU: `Equations` and known origins in, one `Provenance` each out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from haptid.model.equations.equations import Equations

GUESS = "first guess"
"""Status and source of a value that nothing was measured for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Say where the value of a parameter comes from.

    Parameters
    ----------
    source
        Test and campaign, file, or ``first guess``, in words.
    std
        Standard deviation in the parameter's unit; None where unknown.
    status
        Status as a report tells it, ``first guess`` or ``fixed``.
    """

    source: str
    std: float | None = None
    status: str = GUESS


def provenance_of(equations: Equations, given: Mapping[str, Provenance | str]) -> dict[str, Provenance]:
    """Return the provenance of every parameter.

    Parameters
    ----------
    equations
        Equations with the parameters.
    given
        Known provenance by id; a text is the source alone.

    Returns
    -------
    dict
        By id, for all parameters. Those not in ``given`` are first guesses with the standard deviation of their prior.
    """
    result = {}
    for q in equations.parameters:
        entry = given.get(q.id)
        if isinstance(entry, str):
            entry = Provenance(source=entry, status="")
        if entry is None:
            std = q.prior.std if q.prior else None
            entry = Provenance(source=GUESS, std=std, status="fixed" if q.fixed else GUESS)
        result[q.id] = entry
    return result
