"""What the posterior of a joint is about: campaign and configuration in, `Subject` with fit, runs and simulators out.

1. Go on from the fit of an earlier identification, where its results lie in the same folder; else fit here.
2. Where the fit's residual is a position, simulate the joint from its torque, by the compiled kernel or an FMU.
3. Where the fit's residual is a torque, because a position controller made the runs, take the measured motion for input
   and compare the torque: motion and torque pass the same filter (`identification.simulators.inverse_dynamics`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from haptid.fmu_build.building.cached import identification_fmu
from haptid.fmu_build.building.packaging import Kind
from haptid.identification.baseline.baseline import delay_of_torque
from haptid.identification.fit.fit_runs import JointTest, at_needed_step, fit_runs
from haptid.identification.fit.multistart import fit
from haptid.identification.fit.own_bounds import fit_within_own_bounds
from haptid.identification.fit.strategy import choose_for
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.carried_fit import FILE, carried_fit, carried_torque_fit
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.equations_for import name_campaign_in_errors, stated_parameters
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.inverse_dynamics import torque_runs
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.workers.workers import Workers
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.uq.density.forward import EachForward, Forward, TorqueForward, kernel_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """A fit with what the sampler compares.

    Parameters
    ----------
    fit
        Fit at which the posterior begins.
    source
        Where the fit comes from, in words.
    runs
        Runs of positions, or of torques where the fit's residual is a torque.
    simulator
        Simulator of the fit's equations, with sensitivities.
    forward
        Simulation of many parameter sets; None where the sampler chooses the kernel's inner step.
    """

    fit: Fit
    source: str
    runs: tuple[Run, ...]
    simulator: Simulator
    forward: Forward | None = None

    @property
    def share_of_steps(self) -> float:
        """Share of the usual inner steps that the fit needed [1]."""
        return self.fit.inner_step / MODEL.inner_step_s


def find_subject(  # noqa: PLR0913 # a configuration, where its fit may lie, and how it is fitted otherwise
    campaign: Campaign,
    device: Device | None,
    configuration: Configuration,
    equations: Equations,
    out: Path,
    *,
    kind: Kind | None,
    seed: int,
    workers: Workers,
) -> Subject:
    """Find the fit of a joint, and set up what the sampler compares.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configuration
        Free joint, posture and runs.
    equations
        Equations of motion of the joint.
    out
        Folder that may hold the results of an identification.
    kind
        Packaging of the FMU that the sampler runs where positions are compared; None for the compiled kernel.
    seed
        Seed of the starts of a fit that is made here.
    workers
        Workers that run these starts.

    Returns
    -------
    Subject

    Raises
    ------
    NumericalError
        Where a fit is made here, and no start gives a finite simulation.
    """
    where, runs = (campaign, device, configuration, equations, out), configuration.runs
    turned = carried_torque_fit(*where)
    if turned is not None:
        delay = delay_of_torque(runs, device, configuration.posture)
        return _of_torques(turned, runs, delay, f"read from {FILE}")
    carried = carried_fit(*where)
    if carried is not None:
        return _of_positions(carried, runs, f"read from {FILE}", kind)
    options = FitOptions(seed=seed)
    test = JointTest(
        equations=equations, build=kernel_of, runs=runs, device=device, posture=configuration.posture,
        stated=stated_parameters(campaign, configuration.free_joints),
    )  # fmt: skip
    with name_campaign_in_errors(campaign, configuration.free_joints):
        # Only under position control may the torque be the residual; then both are fitted, and the better one counts.
        if choose_for(runs).kind != "open_loop" and equations.drive is None:
            made = fit_runs(test, options=options, workers=workers)
            if made.torque_scored:
                return _of_torques(made.fit, runs, made.compared.delay_s, "made here")

        def fit_position(equations: Equations, options: FitOptions) -> Fit:
            return fit(kernel_of(equations), runs, options=options, workers=workers)

        def needs_finer_step(found: Fit) -> bool:
            return found.observer_gain == 0.0 and at_needed_step(test, found, options) is not None

        # A range that haptid guessed may end before the optimum: the sampler would then start far from it. Where the
        # step is too long, other starts are asked at the finer one alone.
        found = fit_within_own_bounds(
            fit_position, equations, runs, test.own, options, needs_finer_step=needs_finer_step
        )  # fmt: skip
        if (finer := at_needed_step(test, found, options)) is not None:
            again = options.but(start=tuple(map(float, found.theta)))
            fine = finer.simulator(found.equations)
            found = fit(fine, runs, options=again, workers=workers).but(inner_step=finer.step)
    return _of_positions(found, runs, "made here", kind)


def _of_positions(found: Fit, runs: Sequence[Run], source: str, kind: Kind | None) -> Subject:
    # The ranges of the fit: those that haptid chose may have been widened to hold its optimum.
    equations = found.equations
    if kind is None:
        return Subject(fit=found, source=source, runs=tuple(runs), simulator=kernel_of(equations))
    fmu = FmuSimulator.of(identification_fmu(equations, kind=kind), equations).with_step(found.inner_step)
    forward = EachForward(simulator=fmu)
    return Subject(fit=found, source=source, runs=tuple(runs), simulator=fmu, forward=forward)


def _of_torques(found: Fit, runs: Sequence[Run], delay: float, source: str) -> Subject:
    forward = TorqueForward(equations=found.equations)
    simulator = forward.simulator()
    turned = torque_runs(runs, delay, found.values["inertia"])
    return Subject(fit=found, source=source, runs=turned, simulator=simulator, forward=forward)
