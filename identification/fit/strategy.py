"""What a run allows: free simulation, simulation through a stated observer, or scoring the torque.

1. A torque that a position controller made holds the joint where it is told to be: simulated freely, a model that lacks
   something drifts. Simulate through an observer; a single joint swept at constant speed, where speed and acceleration
   say little, has its torque scored instead unless the observer leaves the noise (`identification.fit.fit_runs`).
2. Where an error of the start grows beyond `LIMIT` during a run, what a free simulation leaves is the growth of small
   errors of torque: simulate through an observer that forgets faster than the motion changes.
3. Otherwise simulate freely, the strictest test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from haptid.identification.fit.multistart import fit
from haptid.identification.optimise.workers import Workers
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.error_growth import growth
from haptid.identification.simulators.observer import Observed
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.jackknife import with_jackknife
from haptid.measurement.signals.control_detection import STEADY, position_control, steady_share
from haptid.measurement.signals.smoothing import dominant_period
from haptid.measurement.values.run import Array, Run
from haptid.support.numbers import plain

Kind = Literal["open_loop", "observer", "torque"]
LIMIT = 30.0
"""Growth of an error of the start from which a free simulation is not compared with the data."""
FASTER = 3.0
"""Gain of the observer over the circular frequency of the fastest joint's strongest line."""
LEAST_GAIN, MOST_GAIN = 5.0, 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Strategy:
    """How runs are fitted, why, and the gain [1/s] of the observer where they are simulated through one."""

    kind: Kind
    reason: str
    gain: float = 0.0


OPEN_LOOP = Strategy(kind="open_loop", reason="simulated freely from the recorded torque")


def choose(run: Run, simulator: Simulator | None = None, theta: Array | None = None) -> Strategy:
    """Say how ``run`` can be fitted; growth is judged where ``simulator`` and ``theta`` are given."""
    signs = {j: position_control(run, k) for k, j in enumerate(run.free_joints)}
    signs = {j: sign for j, sign in signs.items() if sign}
    if signs:
        told = "; ".join(f"joint {j}: {sign}" for j, sign in signs.items())
        return _controlled(run, f"{run.file} was recorded under position control ({told})")
    if simulator is None or theta is None:
        return OPEN_LOOP
    factor = growth(simulator, theta, run)
    if factor <= LIMIT:
        return OPEN_LOOP
    gain = observer_gain(run)
    reason = (
        f"an error of the start grows {plain(factor)}-fold during {run.file}: "
        f"simulated with the measured position fed back through an observer of gain {gain:.3g} 1/s"
    )
    return Strategy(kind="observer", reason=reason, gain=gain)


def _controlled(run: Run, why: str) -> Strategy:
    gain = observer_gain(run)
    if len(run.free_joints) == 1 and steady_share(run.t, run.y[:, 0]) > STEADY:
        reason = f"{why}: the measured motion goes in and the torque is scored"
        return Strategy(kind="torque", reason=reason, gain=gain)
    reason = f"{why}: simulated with the measured position fed back through an observer of gain {gain:.3g} 1/s"
    return Strategy(kind="observer", reason=reason, gain=gain)


def observer_gain(run: Run) -> float:
    """Return the observer's gain [1/s]: `FASTER` times 2π over the shortest of the joints' strongest periods."""
    period = min(dominant_period(run.t, y) for y in run.y.T)
    return float(np.clip(round(FASTER * 2.0 * np.pi / period), LEAST_GAIN, MOST_GAIN))


def choose_for(runs: Sequence[Run], simulator: Simulator | None = None, theta: Array | None = None) -> Strategy:
    """Choose for all fitted runs of a configuration together: the most careful of their strategies, largest gain."""
    chosen = [choose(run, simulator, theta) for run in runs if run.use == "fit"]
    for kind in ("torque", "observer"):
        of_kind = [one for one in chosen if one.kind == kind]
        if of_kind:
            return max(of_kind, key=lambda one: one.gain)
    return OPEN_LOOP


def fit_simulated(
    simulator: Simulator,
    runs: Sequence[Run],
    *,
    options: FitOptions | None = None,
    workers: Workers | None = None,
) -> Fit:
    """Fit by free simulation where the runs allow it, else through the observer; the notes of the fit say which.

    Growth is judged at the first guesses, and again at what was found, because a poor guess may move calmly or wildly
    where the machine does not. A free fit that leaves the noise stands, whatever the growth.
    """
    options = options or FitOptions()
    theta = first_guess(simulator) if options.start is None else np.array(options.start)
    strategy = choose_for(runs, simulator, theta)
    if strategy.kind == "open_loop":
        free = fit(simulator, runs, options=options, workers=workers)
        strategy = choose_for(runs, simulator, free.theta)
        if strategy.kind == "open_loop" or quiet(free, options):
            return free
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
    """Whether what the fit left is the sensor's noise."""
    return bool(found.basins[0].over_noise <= options.tolerance)


def first_guess(simulator: Simulator) -> Array:
    """Return the first guesses of all parameters, shape (n_p,)."""
    return np.array([q.initial for q in simulator.equations.parameters])


def free_simulation(simulator: Simulator, found: Fit, runs: Sequence[Run]) -> tuple[str, ...]:
    """Return one sentence per run on what a free simulation would leave, so that nobody takes the observer's for it."""
    sentences = []
    for run in runs:
        if run.use != "excluded":
            y = simulator.simulate(found.theta, run, x0=found.x0.get(run.file)).y[:, : run.y.shape[1]]
            rms = ", ".join(f"{value:.3g}" for value in np.sqrt(np.mean((run.y - y) ** 2, axis=0)))
            sentences.append(f"{run.file}: a free simulation leaves an RMS of {rms} rad")
    return tuple(sentences)
