"""Fits of all configurations in locking order: `Campaign`, `Device` and `Configuration`s in, `Step`s out.

For every configuration, in order:

1. Take the belief over the inertial parameters π as prior of its coefficients, and the values of springs and friction
   that earlier configurations gave as first guesses (`carry_over`).
2. Fit it, or read the fit from the file of an interrupted run.
3. Remove the priors from the estimates again (`measurement_of`) and compare them with earlier tests.
4. Update the belief with these measured coefficients.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from haptid.identification.first_guesses.plain_guess import states_no_friction
from haptid.identification.fit.fit_runs import JointTest, fit_runs
from haptid.identification.links.consistency import Agreement, coefficients_agree, parameters_agree
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.carry_over import carry_over, measurement_of
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.equations_for import equations_for, name_campaign_in_errors, stated_parameters
from haptid.identification.sequence.result_json import fit_from_json
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.workers.watched import Watched
from haptid.identification.workers.workers import Watch, Workers, watch_nothing
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.model.joint.drive_terms import DRIVE_PARAMETERS
from haptid.model.joint.joint_in_device import INERTIAL
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.model.rigid_body.locked_dynamics import Coefficient, locked_motion

Build = Callable[[Equations], Simulator]
"""Function from equations to the simulator that runs them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sequence:
    """Fits the configurations of a campaign one after the other.

    Parameters
    ----------
    campaign
        Campaign with runs and parameter entries.
    device
        Device of the campaign; None for a single joint.
    build
        Function from equations to a simulator: the FMU, or the kernel in process.
    options
        Choices of all fits.
    workers
        Workers that run the starts.
    kept
        Entries of identification.json of an earlier, interrupted run by number of the configuration, from 0.
    tell
        Told number of the configuration, share of it that is done, and figures.
    """

    campaign: Campaign
    device: Device | None
    build: Build
    options: FitOptions
    workers: Workers
    kept: Mapping[int, Mapping[str, Any]]
    tell: Watch = watch_nothing

    def steps(self, configurations: tuple[Configuration, ...]) -> Iterator[Step]:
        """Fit one configuration after the other.

        Parameters
        ----------
        configurations
            Configurations in the order of their fits.

        Yields
        ------
        Step
            Configuration with its fit and its comparisons with earlier ones.

        Raises
        ------
        NumericalError
            Where a fit fails; the message names the campaign's file and the joints' keys.
        InputError
            As `equations_for`.
        """
        belief = LinkBelief.from_device(self.device) if self.device else None
        found: dict[str, float] = {}
        done: list[Step] = []
        for number, configuration in enumerate(configurations):
            coefficients = self._coefficients(configuration)
            equations = self._equations(configuration, belief, coefficients, found)
            step = self._step(number, configuration, equations)
            if belief is not None:
                one = measurement_of(step.fit, coefficients)
                # Compared before the belief is updated: afterwards the coefficients would be compared with themselves.
                agreements = _agreements(step, belief, one, done)
                step = replace(
                    step, agreements=agreements, device_inertia=self._inertia_of(configuration, coefficients)
                )
                if one.coefficients:
                    belief = belief.update(one.coefficients, one.values, one.covariance)
            found |= joint_values(configuration.free_joints, step.fit.values)
            done.append(step)
            yield step

    def _coefficients(self, configuration: Configuration) -> tuple[Coefficient, ...]:
        if self.device is None:
            return ()
        return locked_motion(self.device, configuration.free_joints, configuration.posture).coefficients

    def _inertia_of(self, configuration: Configuration, coefficients: tuple[Coefficient, ...]) -> float | None:
        """Return the inertia that the device's file gives a joint alone; None where the campaign states another."""
        joints = configuration.free_joints
        if self.device is None or len(joints) > 1 or "inertia" in stated_parameters(self.campaign, joints):
            return None
        values, _ = LinkBelief.from_device(self.device).predict(coefficients)
        by_id = dict(zip([c.id for c in coefficients], values.tolist(), strict=True))
        return by_id.get("inertia")

    def _equations(
        self,
        configuration: Configuration,
        belief: LinkBelief | None,
        coefficients: tuple[Coefficient, ...],
        found: Mapping[str, float],
    ) -> Equations:
        joints = configuration.free_joints
        equations = equations_for(self.campaign, self.device, joints, configuration.posture)
        if belief is None:
            return equations
        stated = stated_parameters(self.campaign, joints)
        return carry_over(equations, belief, coefficients, _values_of(joints, found), stated)

    def _step(self, number: int, configuration: Configuration, equations: Equations) -> Step:
        """Read the fit of a configuration from an interrupted run, or make it."""
        kept = self.kept.get(number)
        if kept is not None:
            with suppress(KeyError, TypeError, ValueError, IndexError):  # changed since: it is fitted again
                return self._kept_step(kept, configuration, equations)
        workers = Watched(workers=self.workers, tell=partial(self.tell, number))
        with name_campaign_in_errors(self.campaign, configuration.free_joints):
            made = fit_runs(self._test(configuration, equations), options=self.options, workers=workers)
        return Step(configuration=configuration, fit=made.fit, torque_scored=made.torque_scored, compared=made.compared)

    def _kept_step(self, kept: Mapping[str, Any], configuration: Configuration, equations: Equations) -> Step:
        """Rebuild a step from its entry of identification.json; the comparison with the plain model is made again."""
        fitted = fit_from_json(kept, equations)
        # Figures are those of the fit that was held against the plain model, even where that replaced it.
        judged = kept["replaced"] if fitted.outcome is Outcome.PLAIN else fitted.values
        scored = fitted.outcome is Outcome.TORQUE_SCORED
        test = self._test(configuration, equations).with_positions(fitted)
        compared = test.compare(judged, torque_scored=scored)
        return Step(configuration=configuration, fit=fitted, torque_scored=scored, compared=compared)

    def _test(self, configuration: Configuration, equations: Equations) -> JointTest:
        return JointTest(
            equations=equations,
            build=self.build,
            runs=configuration.runs,
            device=self.device,
            posture=configuration.posture,
            stated=stated_parameters(self.campaign, configuration.free_joints),
            threads=self.options.workers,
            guessed=self.device is not None
            and len(configuration.free_joints) > 1
            and states_no_friction(self.device, configuration.free_joints, configuration.posture),
        )


def joint_values(joints: tuple[int, ...], values: Mapping[str, float]) -> dict[str, float]:
    """Select springs and friction among the values of a configuration, by id with the joint's number.

    Parameters
    ----------
    joints
        Free joints of the configuration.
    values
        Values of its parameters by id; ids of a single joint have no number.

    Returns
    -------
    dict
        Values by id, such as ``Ks_0``; inertial parameters and coefficients are left out, and those of drive and
        controller: the whole device is moved by torques.
    """
    beside = DRIVE_PARAMETERS.union(INERTIAL)
    if len(joints) == 1:
        return {f"{id}_{joints[0]}": value for id, value in values.items() if id not in beside}
    tails = tuple(f"_{j}" for j in joints)
    return {id: v for id, v in values.items() if id.endswith(tails) and id[0] not in "MV"}


def _values_of(joints: tuple[int, ...], found: Mapping[str, float]) -> dict[str, float]:
    """Return what earlier configurations found, by the ids that the equations of these joints have."""
    if len(joints) > 1:
        return dict(found)
    suffix = f"_{joints[0]}"
    return {id.removesuffix(suffix): value for id, value in found.items() if id.endswith(suffix)}


def _agreements(step: Step, belief: LinkBelief, one: Measurement, done: list[Step]) -> tuple[Agreement, ...]:
    """Test coefficients against the belief, springs and friction against the latest test of the same joints.

    Coefficients change with the lock posture, so that only the belief, which knows how, can compare them.
    """
    name, now = step.configuration.name, step.configuration.free_joints
    first = coefficients_agree(f"{name}: inertia and gravity against earlier tests", belief, one)
    made = [first] if first and done else []
    # Later tests of the same joints replace earlier ones in the dictionary.
    latest = {earlier.configuration.free_joints: earlier for earlier in done}
    for before, earlier in latest.items():
        if len(before) == 1 and len(now) > 1 and before[0] in now:
            made += parameters_agree(earlier.fit, step.fit, f"_{before[0]}")
        elif before == now:
            inertial = {c.id for c in one.coefficients} | set(INERTIAL)
            made += [a for a in parameters_agree(earlier.fit, step.fit, "") if a.name not in inertial]
    # The family is known only when all comparisons of this configuration are made.
    return tuple(replace(a, family=len(made)) for a in made)


def links_of(steps: tuple[Step, ...], device: Device) -> tuple[Measurement, ...]:
    """Return the measured coefficients of every step, without the priors of its fit.

    Parameters
    ----------
    steps
        Fitted configurations.
    device
        Device whose locked motion gives the coefficients.

    Returns
    -------
    tuple of Measurement
        One per step; see `measurement_of`.
    """
    return tuple(
        measurement_of(
            step.fit, locked_motion(device, step.configuration.free_joints, step.configuration.posture).coefficients
        )
        for step in steps
    )
