"""The named effect in the model that users run: FMU rebuilt, all parameters refitted by SLSQP through it."""

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
    """The rebuilt FMU and the fit of all parameters through it."""

    fmu: Fmu
    fit: Fit


def rebuild(study: Study, found: Search, effects: tuple[Effect, ...], out: Path, kind: Kind) -> Rebuilt:
    """Build ``joint<j>_<effects>.fmu`` (``joints01_…``) below ``out``, parameters from an SLSQP fit through the FMU.

    The fit starts from the search's optimum at observer gain 0; the search's minima were found by homotopy.
    """
    equations = study.equations(effects, joint=study.joint)
    simulator = FmuSimulator.of(identification_fmu(equations, kind=kind), equations)
    start = tuple(found.best.solution.values[p.id] for p in equations.parameters)
    options = FitOptions(starts=1, gains=(0.0,), start=start, weights=(1.0, 1.0))
    refitted = fit(simulator, (*study.fitted, *study.unseen), options=options)
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
