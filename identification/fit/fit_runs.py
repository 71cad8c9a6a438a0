"""The fit of one configuration: `Equations` and `Run`s in, `Fit` out, by the strategy that the runs allow.

1. Choose a strategy from the runs (`identification.fit.strategy`).
2. Fit by simulation, freely or through an observer, unless the strategy is ``torque``.
3. For ``torque``, fit through an observer with few starts, and keep that fit where its residual is at the noise.
4. Otherwise fit the torque (`identification.fit.torque_fit`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from haptid.identification.fit.strategy import choose_for, fit_simulated, quiet
from haptid.identification.fit.torque_fit import fit_torque
from haptid.identification.optimise.workers import Workers
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.support.numbers import plain


def fit_runs(
    equations: Equations,
    build: Callable[[Equations], Simulator],
    runs: Sequence[Run],
    *,
    options: FitOptions | None = None,
    workers: Workers | None = None,
) -> tuple[Fit, bool]:
    """Fit one configuration by the strategy that its runs allow.

    Parameters
    ----------
    equations
        Equations of the configuration.
    build
        Function from equations to a simulator.
    runs
        All runs of the configuration.
    options
        Choices of the fit; the defaults where None.
    workers
        Workers that run the starts; those of the options where None.

    Returns
    -------
    fit : Fit
        Its notes say which strategy was used and why, where the simulation was not free.
    torque_scored : bool
        Whether the residual is a torque.

    Raises
    ------
    NumericalError
        Where no start gave a finite simulation.
    """
    options = options or FitOptions()
    strategy = choose_for(runs)
    if strategy.kind != "torque":
        return fit_simulated(build(equations), runs, options=options, workers=workers), False
    # The observer comes first because a position is the stricter test: at the noise there, no torque need be scored.
    trial = options.but(starts=min(options.starts, THRESHOLDS.most_starts_of_trial))
    seen = fit_simulated(build(equations), runs, options=trial, workers=workers)
    if quiet(seen, options):
        return seen, False
    found = fit_torque(equations, runs, options=options, workers=workers)
    over = plain(seen.basins[0].over_noise)
    left = f"an observer of gain {strategy.gain:.3g} 1/s would leave {over} times the noise"
    return found.but(notes=(*found.notes, strategy.reason, left)), True
