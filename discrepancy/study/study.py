"""Define the study of one joint: `Campaign` and catalogue in, `Study` out.

A study holds the runs, the equations of the nominal model, the catalogue, and the factory that turns equations into
simulators. Every stage of the search takes a study.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from haptid.discrepancy.study.channels import scored_rows
from haptid.discrepancy.study.sealed import seal
from haptid.discrepancy.study.simulators import Factory, TwoStep
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.fit.zeros_fit import correct_readings, in_positions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.equations_for import equations_for, stated_parameters
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.law import FrictionLaw, Roles
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.slots import check_slots
from haptid.support.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """One joint under study: its runs, its nominal model, the catalogue and the settings of the search.

    Parameters
    ----------
    joint
        Number of the free joint.
    fitted, unseen
        Runs that are fitted, and held-out runs, which choose among candidates.
    base
        Equations of the nominal model without effects; their parameters have first guesses, bounds and priors.
    catalogue
        Catalogue effects by key, in multiples of the joint's scales.
    prismatic
        Whether the joint is prismatic.
    noise_given
        Whether the campaign states the sensor noise; otherwise it is estimated from the readings.
    factory
        Factory that turns equations into a simulator.
    threads
        Number of threads that simulate runs side by side; the results do not depend on it.
    most
        Largest number of catalogue effects that are begun on top of a model; None for no limit.
    effort
        Number of simulated runs after which the search tries no further combinations of effects.
    carried
        Fit of the fitted runs by the identification, which the nominal fit begins at; None where there is none.
    sealed
        Held-out runs that take part in no choice (`discrepancy.study.sealed`).
    own
        Ids of the parameters whose range haptid chose: neither user nor device states it.
    rows_merged
        Number of rows of the recording that each row of the runs stands for (`discrepancy.study.merged_rows`).
    """

    joint: int
    fitted: tuple[Run, ...]
    unseen: tuple[Run, ...]
    base: Equations
    catalogue: Mapping[str, Effect]
    prismatic: bool = False
    noise_given: bool = False
    factory: Factory = field(default_factory=Factory)
    threads: int = 1
    most: int | None = None
    effort: int = THRESHOLDS.study.most_simulated_runs
    carried: Fit | None = None
    sealed: tuple[Run, ...] = ()
    own: tuple[str, ...] = ()
    rows_merged: int = 1

    @property
    def name(self) -> str:
        """Name of the model, for example ``joint3``."""
        return f"joint{self.joint}"

    @property
    def title(self) -> str:
        """Title of the study, for example ``Joint 3``."""
        return f"Joint {self.joint}"

    @property
    def alone(self) -> bool:
        """Whether exactly one joint moves."""
        return len(self.base.joints) == 1

    @property
    def rows(self) -> int:
        """Number of scored residuals of all fitted runs."""
        return sum(scored_rows(run) for run in self.fitted)

    def equations(self, effects: Sequence[Effect] = (), *, joint: int = 0) -> Equations:
        """Return the equations of the nominal model with effects.

        Parameters
        ----------
        effects
            Catalogue effects in SI units.
        joint
            Number under which the equations are built. With the default 0 all joints share their compiled kernels.

        Returns
        -------
        Equations
            Equations without observer.

        Raises
        ------
        InputError
            Where an effect needs a slot that the joint's friction law lacks.
        """
        return joint_equations(
            joint, parameters=self.base.parameters, effects=effects, prismatic=self.prismatic,
            friction=self.base.friction[0], drive=self.base.drive,
        )  # fmt: skip

    def in_si(self, theta: Mapping[str, float]) -> dict[str, Effect]:
        """Convert the catalogue to SI units.

        Parameters
        ----------
        theta
            Fitted parameters of the nominal model by id, from which the scales follow.

        Returns
        -------
        dict
            Effects in SI units by key, without the random ones, which belong to the noise model.
        """
        scales = scales_over(self.fitted, theta, law_named(self.base.friction[0]).roles)
        return {key: e.at(scales) for key, e in self.catalogue.items() if not e.random}

    def in_joint(self, effect: Effect, column: int) -> Effect:
        """Return an effect under the names that it has in the joint at index ``column``: here unchanged.

        Parameters
        ----------
        effect
            Effect of a joint alone.
        column
            Index of the joint; not used, since one joint moves.

        Returns
        -------
        Effect
            ``effect`` itself.
        """
        del column
        return effect

    def simulator(self, effects: Sequence[Effect] = ()) -> TwoStep:
        """Build a simulator of the nominal model with effects.

        Parameters
        ----------
        effects
            Catalogue effects in SI units.

        Returns
        -------
        TwoStep
            Simulator with sensitivities, at the inner steps of the factory.
        """
        return self.factory(self.equations(effects))

    def sketcher(self, effects: Sequence[Effect]) -> TwoStep:
        """Build a simulator that runs many parameter sets at once.

        Parameters
        ----------
        effects
            Catalogue effects in SI units.

        Returns
        -------
        TwoStep
            Simulator for `TwoStep.simulate_many`.
        """
        # Signatures need no sensitivities, the fit of an effect that scores well does. Where joints are coupled or
        # friction has many states, their formulas take seconds an effect, most of them for effects that are not fitted.
        few = self.alone and len(self.base.states) <= THRESHOLDS.study.most_states_of_sketch_with_sensitivities
        return self.factory(self.equations(effects), many=True, tangent=few)


def study_of(campaign: Campaign, joint: int, effects: Mapping[str, Effect], *, threads: int = 1) -> Study:
    """Build the study of one joint of a campaign.

    Parameters
    ----------
    campaign
        Campaign whose runs free this joint alone.
    joint
        Number of the joint.
    effects
        Catalogue effects by key, in multiples of the joint's scales.
    threads
        Number of threads that simulate runs side by side.

    Returns
    -------
    Study
        Study of the joint; its bounds are narrowed to what the runs can reach.

    Raises
    ------
    InputError
        If the campaign has no run of this joint to fit, if the joint's equation is not that of one axis with constant
        inertia, or if an effect of the user's own asks for a slot that the friction law lacks.
    """
    fitted = campaign.runs_of((joint,), "fit")
    if not fitted:
        known = ", ".join(map(str, campaign.joints)) or "none"
        where = f"--joint {joint}"
        raise InputError(where, expected=f"a joint that some run frees alone ({known})", got=str(joint))
    base = equations_for(campaign, device_of(campaign), (joint,))
    slides = bool(fitted[0].prismatic[0])
    law, drive = law_named(base.friction[0]), base.drive
    expected = joint_equations(joint, parameters=base.parameters, prismatic=slides, friction=law.id, drive=drive)
    # The search builds candidates on the equation of one axis. Any other nominal model would be replaced silently.
    if expected.digest != base.digest:
        where = f"joint {joint}"
        raise InputError(where, expected="constant inertia once all others are locked", got=base.title)
    base = within_reach(base, fitted)
    unseen, sealed = seal(campaign.runs_of((joint,), "validate"))
    effects = usable(effects, law)
    stated = stated_parameters(campaign, (joint,))
    own = tuple(q.id for q in base.parameters if q.id not in stated) if device_of(campaign) is None else ()
    return Study(
        joint=joint, fitted=fitted, unseen=unseen, sealed=sealed, base=base, catalogue=effects, prismatic=slides,
        noise_given=campaign.noise_given, threads=threads, own=own,
    )  # fmt: skip


def with_positions(study: Study, zeros: Mapping[str, Array]) -> Study:
    """Take encoder zeros that differ from run to run out of the readings of a study.

    Parameters
    ----------
    study
        Study of one joint or several.
    zeros
        Reading at position 0 of every joint, shape (n_joints,), [rad] or [m], by the file of the run.

    Returns
    -------
    Study
        The same study whose runs hold positions.
    """
    fitted, unseen, sealed = (correct_readings(runs, zeros) for runs in (study.fitted, study.unseen, study.sealed))
    return replace(study, fitted=fitted, unseen=unseen, sealed=sealed)


def begun_at(study: Study, carried: Fit | None) -> Study:
    """Let the nominal fit of a study begin at a fit of the same runs.

    Parameters
    ----------
    study
        Study of one joint or several.
    carried
        Fit of the identification; None where there is none.

    Returns
    -------
    Study
        The same study. Where an estimate lies outside a range of the nominal model, the parameter has the range of that
        fit, which was widened until it held the optimum.
    """
    if carried is None:
        return study
    fit = in_positions(carried)
    ranges = {}
    for q in study.base.parameters:
        if not q.fixed and not q.lower <= fit.values[q.id] <= q.upper:
            wide = fit.equations.parameter(q.id)
            ranges[q.id] = {"lower": min(q.lower, wide.lower), "upper": max(q.upper, wide.upper)}
    return replace(study, carried=fit, base=study.base.with_parameters(ranges))


def usable(effects: Mapping[str, Effect], law: FrictionLaw) -> dict[str, Effect]:
    """Keep the effects that a position can show and whose slots the friction law offers.

    Parameters
    ----------
    effects
        Catalogue effects by key.
    law
        Friction law of the joint.

    Returns
    -------
    dict
        Effects by key that can act in this friction law.

    Raises
    ------
    InputError
        If an effect of the user's own asks for a slot that the law lacks. Dropping it silently would hide that the
        search never looks for it.
    """
    for key, effect in effects.items():
        if key not in catalogue():
            check_slots(effect, law)
    return {key: e for key, e in effects.items() if e.friction_slots <= law.slots and not e.torque_only}


def within_reach(base: Equations, runs: Sequence[Run]) -> Equations:
    """Narrow the bounds of the nominal model to what the runs can reach.

    Bounds of many orders of magnitude would set the scale of the step in a linear parameter, and drown the others.

    Parameters
    ----------
    base
        Equations of the nominal model.
    runs
        Runs that are fitted.

    Returns
    -------
    Equations
        Equations whose parameters of logarithmic scale stay within a factor `largest_bound_over_first_guess` of their
        first guess, and whose stiffness stays below `largest_stiffness_in_torque_per_travel`·max|u|·Kp over the
        travel, but at least at ten times its first guess.
    """
    widest = THRESHOLDS.study.largest_bound_over_first_guess
    changes: dict[str, dict[str, float]] = {
        q.id: {"lower": max(q.lower, q.initial / widest), "upper": min(q.upper, q.initial * widest)}
        for q in base.parameters
        if q.scale == "log" and not q.fixed
    }
    for i, suffix in enumerate(id_suffixes(base.joints)):
        travel = max(float(np.ptp(np.concatenate([run.y[:, i] for run in runs]))), 1e-9)
        torque = max(float(np.abs(run.u[:, i]).max()) for run in runs)
        stiffest = THRESHOLDS.study.largest_stiffness_in_torque_per_travel * torque / travel
        Ks, Kp = base.parameter(f"Ks{suffix}"), base.parameter(f"Kp{suffix}")
        changes[Ks.id] = {"upper": min(Ks.upper, max(stiffest * Kp.initial, 10 * Ks.initial, Ks.lower))}
    return base.with_parameters(changes)


def scales_over(runs: Sequence[Run], theta: Mapping[str, float], roles: Roles) -> Scales:
    """Compute the scales of a joint over its runs.

    Parameters
    ----------
    runs
        Runs of this joint alone.
    theta
        Values of Kp, inertia, Coulomb friction and viscous friction by id, in SI units.
    roles
        Ids under which the friction law keeps its Coulomb and viscous friction.

    Returns
    -------
    Scales
        Scales in SI units; torque, span of positions and speed are kept above zero, since sizes are divided by them.
    """
    y = np.concatenate([run.y[:, 0] for run in runs])
    torque = max(float(np.abs(run.u[:, 0]).max()) for run in runs) * theta["Kp"]
    low, high = float(y.min()), float(y.max())
    span = max(high - low, 1e-9)
    return Scales(
        torque=max(torque, 1e-12),
        position=span / 2,
        centre=(high + low) / 2,
        speed=max(1e-9, *(_speed(run) for run in runs)),
        inertia=theta["inertia"],
        friction=theta[roles.coulomb],
        viscous=theta[roles.viscous],
        duration=max(float(run.t[-1]) for run in runs),
        prismatic=runs[0].prismatic[0],
    )


def _speed(run: Run) -> float:
    """Return the largest mean speed over any fiftieth of the run [rad/s]."""
    span = max(run.t.size // 50, 1)
    return float(np.abs((run.y[span:, 0] - run.y[:-span, 0]) / (run.t[span:] - run.t[:-span])).max())
