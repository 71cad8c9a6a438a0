"""Rebuild the FMU with the named effects: `Study` and `Search` in, `Rebuilt` out.

All parameters are refitted by SLSQP through the FMU that users run.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.study.study import Study
from haptid.fmu_build.building.cached import identification_fmu
from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.description.provenance import Provenance
from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.model.effects.effect import Effect


@dataclass(frozen=True, slots=True, kw_only=True)
class Rebuilt:
    """The rebuilt FMU with the fit through it.

    Parameters
    ----------
    fmu
        FMU with the named effects and the refitted parameters.
    fit
        Fit of all parameters through an FMU of the same equations.
    """

    fmu: Fmu
    fit: Fit


def rebuild(study: Study, found: Search, effects: tuple[Effect, ...], out: Path, kind: Kind) -> Rebuilt:
    """Build the FMU of the nominal model with named effects, its parameters fitted through the FMU.

    Parameters
    ----------
    study
        Study of the search.
    found
        Result of the search, whose optimum is the start.
    effects
        Named effects in SI units.
    out
        Folder in which ``joint<j>_<effects>.fmu`` (``joints01_…``) is written.
    kind
        Kind of the FMU.

    Returns
    -------
    Rebuilt
        FMU and fit.
    """
    equations = study.equations(effects, joint=study.joint)
    simulator = FmuSimulator.of(identification_fmu(equations, kind=kind), equations)
    start = tuple(found.best.solution.values[p.id] for p in equations.parameters)
    # One start without observer is enough: the search has found the minimum by homotopy.
    options = FitOptions(starts=1, gains=(0.0,), start=start, weights=(1.0, 1.0))
    refitted = fit(simulator, (*study.fitted, *study.unseen, *study.sealed), options=options)
    std = dict(zip([p.id for p in equations.parameters], refitted.std, strict=True))
    provenance = {
        p.id: Provenance(
            source="fitted with the named effects",
            std=float(std[p.id]),
            status=refitted.statuses.get(p.id, "identified"),
        )
        for p in equations.parameters
    }
    name = "_".join((study.name, *(e.id for e in effects)))
    fmu = build_fmu(equations, out / f"{name}.fmu", kind=kind, values=refitted.values, provenance=provenance)
    return Rebuilt(fmu=fmu, fit=refitted)
