"""Where a parameter's value in an FMU comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Source in words, standard deviation in the parameter's unit (None where unknown), status as in a report."""

    source: str
    std: float | None = None
    status: str = "first guess"


def provenance_of(equations: Equations, given: Mapping[str, Provenance | str]) -> dict[str, Provenance]:
    """Return the provenance of every parameter; those not in ``given`` are first guesses, with their prior's width."""
    result = {}
    for q in equations.parameters:
        entry = given.get(q.id)
        if isinstance(entry, str):
            entry = Provenance(source=entry, status="")
        if entry is None:
            std = q.prior.std if q.prior else None
            entry = Provenance(source="first guess", std=std, status="fixed" if q.fixed else "first guess")
        result[q.id] = entry
    return result
