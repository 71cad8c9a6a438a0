"""Rebuild the FMU with the named effects: `Study` and `Search` in, refit and `Rebuilt` out.

All parameters are refitted by SLSQP through the FMU that users run.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.study.study import Study
from haptid.fmu_build.accuracy.accuracy import Accuracy
from haptid.fmu_build.building.cached import identification_fmu
from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.description.provenance import Provenance
from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.model.effects.effect import Effect
from haptid.model.thresholds import THRESHOLDS as MODEL


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


def refit(study: Study, found: Search, effects: tuple[Effect, ...], kind: Kind) -> Fit:
    """Fit all parameters of the nominal model with named effects through its FMU.

    Parameters
    ----------
    study
        Study of the search.
    found
        Result of the search, whose optimum is the start.
    effects
        Named effects in SI units.
    kind
        Kind of the FMU.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        Where the reference run of the FMU gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails, the FMU cannot be loaded, or no start gives a finite simulation.
    """
    equations = study.equations(effects, joint=study.joint)
    # Where the search needed a finer step than the FMU's own, the FMU needs it too.
    step = min(MODEL.inner_step_s, study.factory.step)
    simulator = FmuSimulator.of(identification_fmu(equations, kind=kind), equations).with_step(step)
    start = tuple(found.best.solution.values[p.id] for p in equations.parameters)
    # One start without observer is enough: the search has found the minimum by homotopy.
    options = FitOptions(starts=1, gains=(0.0,), start=start, weights=(1.0, 1.0))
    return fit(simulator, (*study.fitted, *study.unseen, *study.sealed), options=options).but(inner_step=step)


def rebuild(refitted: Fit, name: str, out: Path, kind: Kind, accuracy: Accuracy, largest_torque: float) -> Rebuilt:
    """Build the FMU of a refit.

    Parameters
    ----------
    refitted
        Fit with named effects.
    name
        Name of the file without its suffix, ``joint<j>_<effects>`` or ``joints01_…``.
    out
        Folder in which the FMU is written.
    kind
        Kind of the FMU.
    accuracy
        How good the refit is.
    largest_torque
        Largest torque that the runs apply [N m].

    Returns
    -------
    Rebuilt
        FMU and fit.

    Raises
    ------
    InputError
        Where the reference run of the FMU gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """
    equations = refitted.equations
    provenance = {
        q.id: Provenance(
            source="fitted with the named effects",
            std=float(std),
            status=refitted.statuses.get(q.id, "identified"),
        )
        for q, std in zip(equations.parameters, refitted.std, strict=True)
    }
    path = out / f"{name}.fmu"
    fmu = build_fmu(
        equations, path, kind=kind, values=refitted.values, provenance=provenance, accuracy=accuracy,
        step=refitted.inner_step, largest_torque=largest_torque,
    )  # fmt: skip
    return Rebuilt(fmu=fmu, fit=refitted)
