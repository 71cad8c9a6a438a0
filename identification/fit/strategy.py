"""Strategy of a fit: `Run`s and perhaps a `Simulator` in, `Strategy` or the `Fit` by that strategy out.

1. The torque of a position controller holds the joint at the controller's reference, so that a model with a discrepancy
   drifts in a free simulation: simulate through an observer. A single joint swept at constant speed, where speed and
   acceleration say little, has its torque scored instead, unless the residual of the observer is at the noise
   (`identification.fit.fit_runs`).
2. Where an error of the initial position grows beyond `THRESHOLDS.largest_growth_of_start_error` during a run, the
   residual of a free simulation is the growth of small errors of torque: simulate through an observer that forgets
   faster than the motion changes.
3. Otherwise simulate freely, the strictest test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.error_growth import growth
from haptid.identification.simulators.observer import Observed
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.jackknife import with_jackknife
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Workers
from haptid.measurement.signals.control_detection import is_steady_sweep, position_control
from haptid.measurement.signals.smoothing import dominant_period
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.support.numbers import plain

Kind = Literal["open_loop", "observer", "torque"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Strategy:
    """Strategy of a fit.

    Parameters
    ----------
    kind
        ``open_loop`` for free simulation, ``observer``, or ``torque``.
    reason
        Sentence that says why.
    gain
        Observer gain [1/s]; 0 for free simulation.
    """

    kind: Kind
    reason: str
    gain: float = 0.0


OPEN_LOOP = Strategy(kind="open_loop", reason="simulated freely from the recorded torque")


def choose(
    run: Run, simulator: Simulator | None = None, theta: Array | None = None, *, among: Sequence[Run] = ()
) -> Strategy:
    """Choose the strategy that one run allows.

    Parameters
    ----------
    run
        Run to fit.
    simulator, theta
        Simulator and parameters (n_p,) that the growth of an error is computed with; without them only position control
        is judged.
    among
        Runs that share the observer, where one is needed; this run alone where there are none.

    Returns
    -------
    Strategy
    """
    # Position control comes first: under it a free simulation drifts, however slowly errors grow.
    signs = {j: position_control(run, k) for k, j in enumerate(run.free_joints)}
    signs = {j: sign for j, sign in signs.items() if sign}
    if signs:
        told = "; ".join(f"joint {j}: {sign}" for j, sign in signs.items())
        return _choose_under_control(
            run, _shared_gain(run, among), f"{run.file} was recorded under position control ({told})"
        )
    if simulator is None or theta is None:
        return OPEN_LOOP
    factor = growth(simulator, theta, run)
    if factor <= THRESHOLDS.largest_growth_of_start_error:
        return OPEN_LOOP
    gain = _shared_gain(run, among)
    reason = (
        f"an error of the start grows {plain(factor)}-fold during {run.file}: "
        f"simulated with the measured position fed back through an observer of gain {gain:.3g} 1/s"
    )
    return Strategy(kind="observer", reason=reason, gain=gain)


def _shared_gain(run: Run, among: Sequence[Run]) -> float:
    return max(observer_gain(one) for one in among or (run,))


def _choose_under_control(run: Run, gain: float, why: str) -> Strategy:
    if len(run.free_joints) == 1 and is_steady_sweep(run, 0):
        reason = f"{why}: the measured motion goes in and the torque is scored"
        return Strategy(kind="torque", reason=reason, gain=gain)
    reason = f"{why}: simulated with the measured position fed back through an observer of gain {gain:.3g} 1/s"
    return Strategy(kind="observer", reason=reason, gain=gain)


def observer_gain(run: Run) -> float:
    """Compute the observer gain of a run.

    Parameters
    ----------
    run
        Run with the measured positions.

    Returns
    -------
    float
        `THRESHOLDS.observer_gain_over_motion_frequency`·2π/T [1/s] within its limits, T the shortest of the joints'
        dominant periods.
    """
    period = min(dominant_period(run.t, y) for y in run.y.T)
    gain = round(THRESHOLDS.observer_gain_over_motion_frequency * 2.0 * np.pi / period)
    return float(np.clip(gain, THRESHOLDS.least_observer_gain_per_s, THRESHOLDS.largest_observer_gain_per_s))


def choose_for(runs: Sequence[Run], simulator: Simulator | None = None, theta: Array | None = None) -> Strategy:
    """Choose the strategy of all fitted runs of a configuration together.

    Parameters
    ----------
    runs
        All runs of the configuration; those with ``use == "fit"`` count.
    simulator, theta
        As for `choose`.

    Returns
    -------
    Strategy
        ``torque`` where one run needs it, else ``observer`` where one run needs it, else ``open_loop``. One observer is
        for all runs, so that its gain is that of the run whose motion is fastest, whichever run needs it: near the
        limit of growth a small change of the estimates decides which does.
    """
    fitted = [run for run in runs if run.use == "fit"]
    chosen = [choose(run, simulator, theta, among=fitted) for run in fitted]
    for kind in ("torque", "observer"):
        of_kind = [one for one in chosen if one.kind == kind]
        if of_kind:
            return of_kind[0]
    return OPEN_LOOP


def fit_simulated(
    simulator: Simulator,
    runs: Sequence[Run],
    *,
    options: FitOptions | None = None,
    workers: Workers | None = None,
) -> Fit:
    """Fit by free simulation where the runs allow it, else through the observer.

    Parameters
    ----------
    simulator
        Simulator of the configuration.
    runs
        All runs of the configuration.
    options
        Choices of the fit; the defaults where None.
    workers
        Workers that run the starts and refits.

    Returns
    -------
    Fit
        Through the observer, its notes say why and what a free simulation gives, and its ``observer_gain`` is not 0.

    Raises
    ------
    NumericalError
        Where no start gave a finite simulation.
    InputError
        Where a run has a joint without sensor noise and resolution.

    Notes
    -----
    1. Choose a strategy at the first guesses.
    2. Fit freely where that is the choice. The fit stands where the estimates allow free simulation as well, or where
       its residual is at the noise.
    3. Otherwise fit through the observer.
    4. Where the estimates of that fit allow free simulation, or its residual is at the noise, fit freely from them. The
       free fit stands where the estimates allowed it, or where its residual is at the noise.
    5. Otherwise the fit through the observer stands, with the jackknife's standard deviations where its residual is
       above the noise.
    """
    options = options or FitOptions()
    theta = first_guess(simulator) if options.start is None else np.array(options.start)
    strategy = choose_for(runs, simulator, theta)
    if strategy.kind == "open_loop":
        free = fit(simulator, runs, options=options, workers=workers)
        # Judged again at the estimates: a poor guess may damp or amplify errors where the machine does not.
        strategy = choose_for(runs, simulator, free.theta)
        if strategy.kind == "open_loop" or quiet(free, options):
            return free
    # `Observed` raises every smaller gain to its own: levels below it would repeat the last one.
    gains = (*(gain for gain in options.gains if gain > strategy.gain), 0.0)
    seen = fit(Observed(simulator, strategy.gain), runs, options=options.but(gains=gains), workers=workers)
    again = choose_for(runs, simulator, seen.theta)
    if again.kind == "open_loop" or quiet(seen, options):
        free = fit(simulator, runs, options=options.but(start=tuple(seen.theta)), workers=workers)
        if again.kind == "open_loop" or quiet(free, options):
            return free
    if not quiet(seen, options):
        seen = with_jackknife(Observed(simulator, strategy.gain), seen, runs, options.but(gains=(0.0,)), workers)
    notes = (*seen.notes, strategy.reason, *free_simulation(simulator, seen, runs))
    return seen.but(notes=notes, outcome=Outcome.OBSERVED, observer_gain=strategy.gain)


def quiet(found: Fit, options: FitOptions) -> bool:
    """Say whether the residual of a fit is at the noise.

    Parameters
    ----------
    found
        Fit to judge.
    options
        Options with the tolerance.

    Returns
    -------
    bool
        Whether RMS over noise in the best basin is at most ``options.tolerance``.
    """
    return bool(found.basins[0].over_noise <= options.tolerance)


def first_guess(simulator: Simulator) -> Array:
    """Return the first guesses of all parameters of a simulator's equations.

    Parameters
    ----------
    simulator
        Any simulator.

    Returns
    -------
    ndarray, shape (n_p,)
        In the order of ``equations.parameters``.
    """
    return np.array([q.initial for q in simulator.equations.parameters])


def free_simulation(simulator: Simulator, found: Fit, runs: Sequence[Run]) -> tuple[str, ...]:
    """Simulate the runs freely at the estimates and put their residuals into words.

    Parameters
    ----------
    simulator
        Simulator of the configuration, without the observer.
    found
        Fit through the observer.
    runs
        All runs of the configuration; excluded ones are left out.

    Returns
    -------
    tuple of str
        One sentence per run with the RMS of the residual [rad], or [m] of a prismatic joint, so that no reader takes
        the observer's residual for that of a free simulation.
    """
    sentences = []
    for run in runs:
        if run.use != "excluded":
            y = simulator.simulate(found.theta, run, x0=found.x0.get(run.file)).y[:, : run.y.shape[1]]
            values = np.sqrt(np.mean((run.y - y) ** 2, axis=0))
            units = [unit_for("rad", [slides]) for slides in run.prismatic]
            rms = ", ".join(f"{value:.3g} {unit}" for value, unit in zip(values, units, strict=True))
            sentences.append(f"{run.file}: a free simulation leaves an RMS of {rms}")
    return tuple(sentences)
