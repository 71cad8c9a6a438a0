"""The fit of one configuration: `Equations` and `Run`s in, `Fitted` out, by the strategy that the runs allow.

1. Where the recorded controller closes the loop, fit by simulation through it, from the recorded reference, with a
   restrained Stribeck curve, without a spring first and with one where the runs show it. Otherwise choose a strategy
   from the runs (`identification.fit.strategy`).
2. Fit by simulation, freely or through an observer. Under position control few starts do at first.
3. Keep that fit where its residual is at the noise: a position is the stricter test. Above the noise its standard
   deviations are widened by the jackknife, and of a model that explains nothing no parameter is identified.
   Where encoder zeros of each run leave clearly less, they are fitted too (`identification.fit.zeros_fit`).
4. Under position control of a single joint, fit the torque as well (`identification.fit.torque_fit`), behind the delay
   that the plain model found first (`identification.baseline.delay`), and keep the fit
   with the better figures (`Figures.badness`) on the fitted runs. Where both are as good, the torque is told: the
   observer drags a joint on that should stick, and leaves its friction open.
5. Hold the fit against the plain model. Where that predicts the runs that no fit saw better, it is the result.
6. Tell spring, gravity and stiction that the data do not need as absent (`identification.statistics.absent`).

A fit on a bound that haptid chose is repeated within a wider range first (`identification.fit.own_bounds`). Where the
error of the inner step shows beside the noise, it is repeated at a finer one (`identification.optimise.inner_step`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.baseline.compared import Compared
from haptid.identification.baseline.driven import compare_driven
from haptid.identification.first_guesses.plain_guess import friction_left_open
from haptid.identification.fit.multistart import fit, from_optimum, with_agreement
from haptid.identification.fit.own_bounds import fit_within_own_bounds, largest_command
from haptid.identification.fit.plain_fit import plain_fit
from haptid.identification.fit.strategy import choose_for, fit_simulated, quiet
from haptid.identification.fit.stribeck_restraint import restrain_stribeck
from haptid.identification.fit.torque_fit import fit_torque
from haptid.identification.fit.zeros_fit import correct_readings, encoder_zeros, fit_with_zeros
from haptid.identification.optimise.inner_step import finer_step
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.protocol import Simulator, at_step
from haptid.identification.statistics.absent import (
    SPRING,
    with_absent_terms,
    without_absent_spring,
    without_spring,
)
from haptid.identification.statistics.jackknife import unknowns_of, with_jackknife
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Workers
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.support.numbers import plain


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """Fit of a configuration.

    Parameters
    ----------
    fit
        Its notes say which strategy was used and why, where the simulation was not free.
    torque_scored
        Whether the residual is a torque.
    compared
        The plain model, and the figures of both models on every run.
    """

    fit: Fit
    torque_scored: bool
    compared: Compared


@dataclass(frozen=True, slots=True, kw_only=True)
class JointTest:
    """What is fitted.

    Parameters
    ----------
    equations
        Equations of the configuration.
    build
        Function from equations to a simulator.
    runs
        All runs of the configuration.
    device
        Device of the campaign; None for a single joint.
    posture
        Positions of the locked joints [rad]; may be empty without a device.
    stated
        Ids of the parameters that the user stated.
    threads
        Threads that simulate the runs of `compare` side by side; the result does not depend on their number.
    guessed
        Whether the first guesses are those of the plain model of these runs, and not those of a device.
    step
        Longest inner step of the simulations [s].
    """

    equations: Equations
    build: Callable[[Equations], Simulator]
    runs: Sequence[Run]
    device: Device | None = None
    posture: tuple[float, ...] = ()
    stated: tuple[str, ...] = ()
    threads: int = 1
    guessed: bool = False
    step: float = MODEL.inner_step_s

    def simulator(self, equations: Equations) -> Simulator:
        """Build the simulator of equations at the inner step of the test.

        Parameters
        ----------
        equations
            Equations of the configuration.

        Returns
        -------
        Simulator
        """
        return at_step(self.build(equations), self.step)

    @property
    def own(self) -> tuple[str, ...]:
        """Ids of the parameters whose range haptid chose: neither user nor device states it."""
        if self.device is not None:
            return friction_left_open(self.device, self.runs[0].free_joints, self.posture, self.stated)
        return tuple(q.id for q in self.equations.parameters if q.id not in self.stated)

    def compare(self, values: Mapping[str, float], *, torque_scored: bool = False) -> Compared:
        """Hold a fit against the plain model.

        Parameters
        ----------
        values
            Fitted values by parameter id, in SI units.
        torque_scored
            Whether they were fitted to the torque, behind the delay that the plain model finds.

        Returns
        -------
        Compared
            The plain model, and the figures of both models on every run.
        """
        theta = np.array([values[q.id] for q in self.equations.parameters])
        return compare_driven(
            self.equations,
            theta,
            self.runs,
            self.device,
            self.posture,
            threads=self.threads,
            torque_scored=torque_scored,
            step=self.step,
        )

    @property
    def largest_torque(self) -> float:
        """Largest torque of the runs that are fitted [N m], or [N].

        Infinite for a drive, whose command is none, and for a free swing, whose torque is zero throughout.
        """
        return largest_command(self.equations, self.runs) or np.inf

    @property
    def resolved(self) -> tuple[float, ...]:
        """Standard deviation of the mean position of all fitted rows, for each joint [rad] ([m])."""
        fitted = [run for run in self.runs if run.use == "fit"]
        rows = sum(run.t.size for run in fitted)
        return tuple(np.min([run.sensor_std for run in fitted], axis=0) / np.sqrt(rows)) if rows else ()

    def with_positions(self, found: Fit) -> JointTest:
        """Return the same test with positions for readings, where the fit found encoder zeros.

        Parameters
        ----------
        found
            Fit of the runs.

        Returns
        -------
        JointTest
            Both models of `compare` are then held against positions.
        """
        return replace(self, runs=correct_readings(self.runs, encoder_zeros(found)))


def fit_runs(test: JointTest, *, options: FitOptions | None = None, workers: Workers | None = None) -> Fitted:
    """Fit one configuration by the strategy that its runs allow.

    Parameters
    ----------
    test
        Equations, runs, and what is known of them.
    options
        Choices of the fit; the defaults where None.
    workers
        Workers that run the starts; those of the options where None.

    Returns
    -------
    Fitted

    Raises
    ------
    NumericalError
        Where no start gave a finite simulation.
    """
    begun = time.perf_counter()
    made = _choose_fit(test, options or FitOptions(), workers)
    return replace(made, fit=made.fit.but(wall_s=time.perf_counter() - begun))


def _choose_fit(test: JointTest, options: FitOptions, workers: Workers | None) -> Fitted:
    """Fit as the runs allow, and take the plain model where it is better."""
    if test.guessed:
        # Least squares have found the basin; starts around it would each run for as long as the first.
        options = options.but(starts=min(options.starts, THRESHOLDS.most_starts_beside_plain_guess))
    drive = test.equations.drive
    closed = drive is not None and drive.is_closed
    best = _fit_closed(test, options, workers) if closed else _best_of_both(test, options, workers)
    # A position at the noise is the stricter test, and settles it; a torque at its noise may still predict worse.
    settled = quiet(best.fit, options) and not best.torque_scored
    # The plain model of a motor stands on the torque constant that the fit found, and cannot replace that fit.
    known_torque = drive is None or drive.commands_torque
    if best.compared.plain_is_better and not settled and known_torque:
        made = plain_fit(test.simulator(test.equations), best.fit, best.compared, test.runs)
        return replace(best, fit=made, torque_scored=False)
    if closed:
        return best
    if best.fit.outcome is Outcome.UNEXCITED:
        # Without a scale of the torques no size tells what is absent, and ends of ranges and regimes say nothing.
        return replace(best, fit=best.fit.but(warnings=()))
    # A fit of the torque has no noise of a position.
    resolved = () if best.torque_scored else test.resolved
    return replace(best, fit=with_absent_terms(best.fit, test.largest_torque, resolved))


def _best_of_both(test: JointTest, options: FitOptions, workers: Workers | None) -> Fitted:
    """Fit by simulation and, under position control of a single joint, the torque; return the better one."""
    strategy = choose_for(test.runs)
    # The torque of another drive hangs on parameters that are fitted with the rest: it cannot be scored.
    both = strategy.kind != "open_loop" and len(test.runs[0].free_joints) == 1 and test.equations.drive is None
    test, seen = _fit_motion(test, options, workers, is_trial=both)
    best = Fitted(fit=seen, torque_scored=False, compared=test.with_positions(seen).compare(seen.values))
    if quiet(seen, options) or not both:
        return best
    scored = _score_torque(test, seen, best.compared, options, workers)
    lead = scored.compared.badness("model", "fit") - best.compared.badness("model", "fit")
    return best if lead > THRESHOLDS.largest_lead_of_observer else scored


def _fit_motion(
    test: JointTest, options: FitOptions, workers: Workers | None, *, is_trial: bool
) -> tuple[JointTest, Fit]:
    """Fit by simulation; return the test at the inner step that the motion needs, and the fit at that step.

    A trial comes before a fit of the torque: it has few starts, keeps its ranges, and gets no encoder zeros.
    """
    first = options.but(starts=min(options.starts, THRESHOLDS.most_starts_of_trial)) if is_trial else options

    def fit_position(equations: Equations, options: FitOptions) -> Fit:
        return fit_simulated(test.simulator(equations), test.runs, options=options, workers=workers)

    def needs_finer_step(found: Fit) -> bool:
        return found.observer_gain == 0.0 and at_needed_step(test, found, options) is not None

    def fit_within(equations: Equations, options: FitOptions) -> Fit:
        # Through the observer of a controlled joint stiction costs nothing, and a wider range would only let it grow.
        own = () if is_trial else test.own
        return fit_within_own_bounds(
            fit_position, equations, test.runs, own, options, needs_finer_step=needs_finer_step
        )  # fmt: skip

    seen = fit_within(test.equations, first)
    finer = at_needed_step(test, seen, options) if choose_for(test.runs).kind == "open_loop" else None
    if finer is not None:
        alone = seen.observer_gain == options.gains[-1]
        again = from_optimum(seen, options, alone=alone)
        finer, made = _fit_motion(finer, again, workers, is_trial=is_trial)
        # The minimum moves little with the step: a descent from it stays in the basin on which the starts agreed.
        return finer, with_agreement(made, seen, options) if alone else made
    if not is_trial and not quiet(seen, options):
        seen = fit_with_zeros(fit_within, fit_position, seen, test.runs, options) or seen
    return test, _widen_above_noise(test, seen, options, workers).but(inner_step=test.step)


def _score_torque(
    test: JointTest, seen: Fit, compared: Compared, options: FitOptions, workers: Workers | None
) -> Fitted:
    """Fit the torque of a controlled joint, and say what the fit through the observer ``seen`` would leave."""
    found = fit_torque(
        test.equations, test.runs, stated=test.stated, own=test.own, delay=compared.delay_s,
        sliding=compared.sliding_friction,
        position=test.simulator(test.equations), options=options, workers=workers,
    )  # fmt: skip
    strategy = choose_for(test.runs)
    over = plain(seen.basins[0].over_noise)
    left = f"an observer of gain {strategy.gain:.3g} 1/s would leave {over} times the noise"
    found = found.but(notes=(*found.notes, strategy.reason, left))
    return Fitted(fit=found, torque_scored=True, compared=test.compare(found.values, torque_scored=True))


def at_needed_step(test: JointTest, found: Fit, options: FitOptions) -> JointTest | None:
    """Find the inner step that the minimum of a free simulation needs.

    Parameters
    ----------
    test
        What was fitted.
    found
        Its fit.
    options
        Choices of the fit.

    Returns
    -------
    JointTest or None
        The test at a finer step, with the ranges of the fit; None where the fit has the step that it needs.

    Notes
    -----
    Asked of a fit twice where its ranges were widened: a few simulations without sensitivities, beside the hundreds of
    its descent.
    """
    runs = tuple(run for run in test.runs if run.use == "fit")
    problem = Problem.of(test.build(found.equations), runs, options)
    step = finer_step(problem, unknowns_of(problem, found))
    return replace(test, equations=found.equations, step=step) if step < test.step else None


def _widen_above_noise(test: JointTest, found: Fit, options: FitOptions, workers: Workers | None) -> Fit:
    """Widen the standard deviations of a free simulation above the noise, whose model does not fit.

    The parts of the motion must agree on a parameter (`identification.statistics.jackknife`); of a model that explains
    nothing no parameter is identified. Fits through an observer come with the jackknife.
    """
    if found.outcome is Outcome.UNEXCITED:
        return _without_identified(found)
    if found.outcome not in (Outcome.ABOVE_NOISE, Outcome.LONELY, Outcome.UNEXPLAINED):
        return found
    simulator = test.simulator(found.equations)
    wider = with_jackknife(simulator, found, test.runs, options.but(gains=(0.0,)), workers)
    return _without_identified(wider) if found.outcome is Outcome.UNEXPLAINED else wider


def _without_identified(found: Fit) -> Fit:
    statuses = {id: "unidentifiable" if status == "identified" else status for id, status in found.statuses.items()}
    return found.but(statuses=statuses)


def _fit_closed(test: JointTest, options: FitOptions, workers: Workers | None) -> Fitted:
    """Fit by simulation through the recorded controller, which holds the simulation near the measured motion.

    A controller of low gain leaves false minima, which an observer beside it takes away; few starts do then. The
    Stribeck curve is held as in a fit of the torque: a controlled joint hardly creeps. A spring that a model above the
    noise does not need is left out, because it takes the place of what is missing. From first guesses it does so at
    once, and the fit ends far from the joint: hence the fit without it comes first.
    """
    options = options.but(
        gains=THRESHOLDS.observer_gains_beside_controller,
        method="gauss_newton",
        starts=min(options.starts, THRESHOLDS.most_starts_beside_controller),
    )
    equations = restrain_stribeck(test.equations, test.runs, test.stated)

    def fit_closed(equations: Equations, options: FitOptions) -> Fit:
        return fit(test.simulator(equations), test.runs, options=options, workers=workers)

    none = without_spring(equations, test.own)
    found = fit_within_own_bounds(fit_closed, none or equations, test.runs, test.own, options)
    if none is not None:
        found = _with_spring_if_seen(test, fit_closed, equations, found, options)
    wider = _widen_above_noise(test, found, options.but(gains=(0.0,)), workers)
    found = with_absent_terms(wider, test.largest_torque, test.resolved)
    found = found.but(notes=(*found.notes, "simulated through the recorded controller from the recorded reference"))
    return Fitted(fit=found, torque_scored=False, compared=test.compare(found.values))


def _with_spring_if_seen(
    test: JointTest,
    fit_closed: Callable[[Equations, FitOptions], Fit],
    equations: Equations,
    springless: Fit,
    options: FitOptions,
) -> Fit:
    """Free the spring at the optimum without it, and return that fit where it is at the noise or the spring is seen."""
    known = {id: value for id, value in springless.values.items() if id not in SPRING}
    ranged = equations.with_parameters(
        {q.id: {"lower": q.lower, "upper": q.upper} for q in springless.equations.parameters if q.id not in SPRING}
    )
    start = tuple(known.get(q.id, q.initial) for q in equations.parameters)
    free = options.but(gains=(0.0,), starts=1)
    sprung = fit_closed(ranged, free.but(start=start))
    if quiet(sprung, options):
        # Further starts tell whether the minimum is the only one.
        return fit_closed(ranged, options.but(start=tuple(sprung.theta)))
    if sprung.cost >= springless.cost or without_absent_spring(sprung, test.own) is not None:
        return springless
    return fit_within_own_bounds(fit_closed, ranged, test.runs, test.own, options.but(start=tuple(sprung.theta)))
