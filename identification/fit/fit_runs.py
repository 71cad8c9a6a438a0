"""The fit of one configuration, by whichever strategy its runs allow."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from haptid.identification.fit.strategy import choose_for, fit_simulated, quiet
from haptid.identification.fit.torque_fit import fit_torque
from haptid.identification.optimise.workers import Workers
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.support.numbers import plain

TRIAL_STARTS = 2


def fit_runs(
    equations: Equations,
    build: Callable[[Equations], Simulator],
    runs: Sequence[Run],
    *,
    options: FitOptions | None = None,
    workers: Workers | None = None,
) -> tuple[Fit, bool]:
    """Return the fit of ``runs``, and whether it is the torque that was fitted.

    A sweep under position control is simulated through an observer first: what reaches the noise there needs no torque
    scored, and a position is the stricter test.
    """
    options = options or FitOptions()
    strategy = choose_for(runs)
    if strategy.kind != "torque":
        return fit_simulated(build(equations), runs, options=options, workers=workers), False
    trial = options.but(starts=min(options.starts, TRIAL_STARTS))
    seen = fit_simulated(build(equations), runs, options=trial, workers=workers)
    if quiet(seen, options):
        return seen, False
    found = fit_torque(equations, runs, options=options, workers=workers)
    over = plain(seen.basins[0].over_noise)
    left = f"an observer of gain {strategy.gain:.3g} 1/s would leave {over} times the noise"
    return found.but(notes=(*found.notes, strategy.reason, left)), True
