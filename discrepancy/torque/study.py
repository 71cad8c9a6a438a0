"""Define the study of one joint under position control: `Campaign` in, `TorqueStudy` out, motion in and torque out.

Where a campaign has no run to validate on, stretches of the run are held out that alternate with fitted ones. A sweep
there and back then shows every held-out position once more, in the other direction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.study.sealed import seal
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.drive import KnownDrive, known_drive
from haptid.discrepancy.torque.readable import delays_torque, with_measured_load
from haptid.discrepancy.torque.rows import alternating
from haptid.identification.baseline.baseline import fit_baseline
from haptid.identification.first_guesses.plain_guess import guess_along
from haptid.identification.fit.stribeck_restraint import restrain_stribeck
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.equations_for import equations_for, stated_parameters
from haptid.identification.simulators.inverse_dynamics import (
    TorqueSimulator,
    measured_motion,
    torque_equations,
    torque_runs,
)
from haptid.identification.simulators.slow_rows import Mask, rests, turns
from haptid.identification.statistics.absent import SPRING
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import Equations
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.cache import cached_kernel
from haptid.model.thresholds import THRESHOLDS as KERNELS


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFriction:
    """Friction that differs from run to run, and was taken out of the runs (`discrepancy.torque.run_friction`).

    Parameters
    ----------
    levels
        Friction of each run over that of the model [1], by file.
    before, after
        RMS of the nominal model's residual on held-out rows before and after [N m].
    """

    levels: Mapping[str, float]
    before: float
    after: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueStudy:
    """One joint whose torque is scored: its runs, its held-out rows and its nominal model.

    Parameters
    ----------
    joint
        Number of the joint.
    runs
        Runs with the position as ``u`` and the torque as ``y``.
    seen
        Whether each row of every run is fitted, shape (n_t,) each.
    base
        Equations of the nominal model without effects.
    prismatic
        Whether the joint is prismatic.
    drive
        What makes the torque of ``runs``, and its parameters; None where the torque was recorded.
    recorded
        The fitted and held-out runs as they were recorded; empty where the study was not made from a campaign.
    resting
        Whether the joint rests at each row, shape (n_t,) each: friction holds it there with any torque up to its level,
        whoever made the torque, so that the motion does not tell it. Empty where every row counts.
    turning
        Whether each row is near a reversal, shape (n_t,) each: it is fitted, but names no effect. Empty where every row
        does.
    weight_of_turning
        Weight of the residual of rows near a reversal in a fit [1], at most that of all others, which is 1.
    sealed
        Runs, turned alike, that take part in no choice (`discrepancy.study.sealed`).
    recorded_sealed
        The same as they were recorded.
    delay
        Delay of the recorded torque that the plain model finds [s], which ``runs`` have behind them; 0 without one.
    stated
        Ids of the parameters that the user stated, whose ranges stay as they are.
    threads
        Number of threads that fit and scan side by side; the results do not depend on it.
    friction_by_run
        What the friction of the runs differed by, which ``runs`` have no more; None where it was not taken out.
    """

    joint: int
    runs: tuple[Run, ...]
    seen: tuple[Mask, ...]
    base: Equations
    prismatic: bool
    drive: KnownDrive | None = None
    recorded: tuple[Run, ...] = ()
    resting: tuple[Mask, ...] = ()
    turning: tuple[Mask, ...] = ()
    weight_of_turning: float = 1.0
    sealed: tuple[Run, ...] = ()
    recorded_sealed: tuple[Run, ...] = ()
    delay: float = 0.0
    stated: tuple[str, ...] = ()
    threads: int = 1
    friction_by_run: RunFriction | None = None

    @property
    def moving(self) -> tuple[Mask, ...]:
        """Whether each row counts, shape (n_t,) each."""
        return tuple(~rest for rest in self.resting) or tuple(np.ones(run.t.size, dtype=bool) for run in self.runs)

    @property
    def fitted_rows(self) -> tuple[Mask, ...]:
        """Whether each row counts and is fitted, shape (n_t,) each."""
        return tuple(seen & moving for seen, moving in zip(self.seen, self.moving, strict=True))

    @property
    def unseen_rows(self) -> tuple[Mask, ...]:
        """Whether each row counts and is held out, shape (n_t,) each."""
        return tuple(~seen & moving for seen, moving in zip(self.seen, self.moving, strict=True))

    @property
    def weights(self) -> tuple[Array, ...]:
        """Weight of the residual of each row in a fit that it takes part in [1], shape (n_t,) each."""
        ones = tuple(np.ones(run.t.size) for run in self.runs)
        return tuple(np.where(turning, self.weight_of_turning, 1.0) for turning in self.turning) or ones

    def names(self, rows: Sequence[Mask]) -> Mask:
        """Return which of some rows name effects: those away from reversals, or all where none are.

        Parameters
        ----------
        rows
            Rows of every run, shape (n_t,) each.

        Returns
        -------
        ndarray of bool, shape (n_rows,)
            One entry for each of these rows, the runs behind one another.
        """
        return np.concatenate([naming[r] for naming, r in zip(self.naming_rows(rows), rows, strict=True)])

    def naming_rows(self, rows: Sequence[Mask]) -> tuple[Mask, ...]:
        """Return which of some rows name effects, as `names`, by run.

        Parameters
        ----------
        rows
            Rows of every run, shape (n_t,) each.

        Returns
        -------
        tuple of ndarray of bool
            Shape (n_t,) each.
        """
        away = tuple(r & ~turning for turning, r in zip(self.turning, rows, strict=True)) if self.turning else ()
        return away if any(r.any() for r in away) else tuple(rows)

    @property
    def guessed_friction(self) -> dict[str, float]:
        """First guesses of the friction law by id."""
        return {row.id: self.base.parameter(row.id).initial for row in law_named(self.base.friction[0]).parameters}

    @property
    def repeats(self) -> bool:
        """Whether positions are passed more than twice; otherwise effects over time and over position look alike."""
        turns = 0
        for run in self.runs:
            v = measured_motion(run)[:, 1]
            # Slow rows are left out, since noise may turn the sign of their speed.
            least = THRESHOLDS.torque.slow_share_of_fast_speed * np.quantile(np.abs(v), 0.9)
            moving = np.sign(v[np.abs(v) > least])
            turns += int(np.sum(moving[1:] != moving[:-1]))
        return len(self.runs) + turns > 2

    def equations(self, effects: Sequence[Effect] = ()) -> Equations:
        """Return the equations of the nominal model with ``effects``, from torque to position.

        Parameters
        ----------
        effects
            Effects that are added to the nominal model.

        Returns
        -------
        Equations
            Equations of the joint alone.

        Raises
        ------
        InputError
            Where an effect needs a slot that the friction law lacks.
        """
        return joint_equations(
            self.joint, parameters=self.base.parameters, effects=effects, prismatic=self.prismatic,
            friction=self.base.friction[0],
        )  # fmt: skip

    def driven_equations(self, effects: Sequence[Effect] = ()) -> Equations:
        """Return the equations of the nominal model with ``effects``, from the drive's inputs where it has one.

        Parameters
        ----------
        effects
            Effects that are added to the nominal model.

        Returns
        -------
        Equations
            Without a drive those of `equations`.

        Raises
        ------
        InputError
            Where an effect needs a slot that the friction law lacks.
        """
        if self.drive is None:
            return self.equations(effects)
        return joint_equations(
            self.joint, parameters=(*self.base.parameters, *self.drive.rows), effects=effects,
            prismatic=self.prismatic, friction=self.base.friction[0], drive=self.drive.drive,
        )  # fmt: skip

    def simulator(self, effects: Sequence[Effect] = (), *, many: bool = False) -> TorqueSimulator:
        """Build the simulator from measured motion to torque.

        Parameters
        ----------
        effects
            Effects in SI units that are `readable`.
        many
            Whether it computes many parameter sets at once, without sensitivities, instead of one with them.

        Returns
        -------
        TorqueSimulator
            Simulator of the nominal model with ``effects``.

        Raises
        ------
        ValueError
            If the equations cannot be read from motion to torque.
        """
        late = [e for e in effects if delays_torque(e)]
        nominal = self.equations()
        if late:
            # States of the torque's path and of the load then follow the recorded torque.
            prompt = self.equations([e for e in effects if e not in late])
            equations = torque_equations(self.equations(effects), prompt, nominal=nominal)
        else:
            equations = torque_equations(with_measured_load(self.equations(effects)), nominal=nominal)
        made = cached_kernel(equations, many=many, tangent=not many, substeps=KERNELS.most_substeps_of_inner_step)
        step = THRESHOLDS.torque.inner_step_s
        return TorqueSimulator(equations, replace(made, kernel=replace(made.kernel, step=step)))

    def scales(self, values: Mapping[str, float]) -> Scales:
        """Return the joint's scales over its runs, at fitted parameters ``values`` by id.

        Parameters
        ----------
        values
            Fitted parameters by id, in SI units: inertia, Coulomb and viscous friction are read.

        Returns
        -------
        Scales
            Largest torque, range of positions, 99 % quantile of the speed, longest duration, and the parameters read.
        """
        q = np.concatenate([run.u[:, 0] for run in self.runs])
        v = np.concatenate([measured_motion(run)[:, 1] for run in self.runs])
        roles = law_named(self.base.friction[0]).roles
        return Scales(
            torque=max(float(np.abs(run.y).max()) for run in self.runs), position=float(np.ptp(q)) / 2,
            centre=float(q.max() + q.min()) / 2, speed=float(np.quantile(np.abs(v), 0.99)), inertia=values["inertia"],
            friction=values[roles.coulomb], viscous=values[roles.viscous],
            duration=max(float(run.t[-1]) for run in self.runs), prismatic=self.prismatic,
        )  # fmt: skip


def torque_study_of(campaign: Campaign, joint: int, carried: Fit | None = None, *, threads: int = 1) -> TorqueStudy:
    """Build the study of one joint whose runs were recorded under position control.

    Parameters
    ----------
    campaign
        Campaign whose runs free this joint alone.
    joint
        Number of the joint.
    carried
        Fit of the runs by the identification, whose drive makes the torque; the stated drive where None.
    threads
        Number of threads that fit and scan side by side.

    Returns
    -------
    TorqueStudy
        Study with held-out rows: the runs to validate on, or alternating stretches of runs that are used for both.

    Raises
    ------
    InputError
        As `equations_for`.
    """
    fitted, (unseen, sealed) = campaign.runs_of((joint,), "fit"), seal(campaign.runs_of((joint,), "validate"))
    # A file with both uses was divided in time; here its rows alternate instead, so that held-out stretches lie all
    # over it.
    cut = {run.file for run in fitted} & {run.file for run in unseen}
    sealed = tuple(run for run in sealed if run.file not in cut)
    runs = [*(run for run in fitted if run.file not in cut), *unseen]
    slides, stated = bool(fitted[0].prismatic[0]), stated_parameters(campaign, (joint,))
    base = equations_for(campaign, device_of(campaign), (joint,))
    drive = known_drive(base, carried)
    if carried is not None and not set(SPRING) & set(carried.free):
        base = base.with_parameters({id: {"initial": 0.0, "fixed": True} for id in SPRING if _has(base, id)})
    # The torque of a drive is computed along the motion, without a delay.
    delay = 0.0
    if drive is not None:
        base = restrain_presliding(drive.rigid(base, prismatic=slides), runs, stated)
    else:
        base, delay = _guess_and_delay(base, campaign, fitted, unseen)
    # The masks hold rows out, so the runs themselves are scored from the first row on.
    whole = [run.but(score_from=0) for run in (*runs, *sealed)]
    # One filter for all runs of the machine, the sealed ones too.
    both = torque_runs(whole, delay) if drive is None else drive.turn(whole)
    turned, kept = both[: len(runs)], both[len(runs) :]
    seen = [run.use == "fit" if run.file not in cut else alternating(run.t.size) for run in turned]
    return TorqueStudy(
        joint=joint,
        runs=turned,
        seen=tuple(np.broadcast_to(np.asarray(s), run.t.shape) for s, run in zip(seen, turned, strict=True)),
        base=restrain_stribeck(base, fitted, stated),
        prismatic=slides,
        drive=drive,
        recorded=(*fitted, *unseen),
        resting=tuple(rests(run) for run in turned),
        turning=tuple(turns(run) for run in turned),
        sealed=kept,
        recorded_sealed=sealed,
        delay=delay,
        stated=tuple(stated),
        threads=threads,
    )


def _guess_and_delay(
    base: Equations, campaign: Campaign, fitted: Sequence[Run], unseen: Sequence[Run]
) -> tuple[Equations, float]:
    """Return the equations with first guesses of the plain model, and its delay of the torque [s].

    Of a joint of a device the guesses are the device's.
    """
    device, joint = device_of(campaign), fitted[0].free_joints
    plain = fit_baseline([*fitted, *unseen], device, fitted[0].posture.tolist(), [1.0])
    if device is None:
        base = guess_along(base, plain, fitted, stated_parameters(campaign, joint))
    return base, 0.0 if plain is None else plain.delay_s


def _has(base: Equations, id: str) -> bool:
    return any(q.id == id and not q.fixed for q in base.parameters)


def restrain_presliding(base: Equations, runs: Sequence[Run], stated: Sequence[str]) -> Equations:
    """Hold the distance before sliding, Coulomb friction over stiffness, below a share of the travel.

    A bristle as long as the travel is a spring with a start of its own in every run, and the runs of a drive that rests
    between its motions are short. Tendons may drag along over a large part of the travel; the gear of a drive does not.

    Parameters
    ----------
    base
        Equations of the nominal model, whose first guesses are those of the data.
    runs
        Runs of the joint.
    stated
        Ids of the parameters that the user stated, which stay as they are.

    Returns
    -------
    Equations
        With the smallest stiffness in presliding.
    """
    roles = law_named(base.friction[0]).roles
    if not roles.stiffness or roles.stiffness in stated:
        return base
    q = np.concatenate([run.y[:, 0] for run in runs])
    longest = THRESHOLDS.torque.longest_presliding_over_travel * float(np.ptp(q))
    softest = base.parameter(roles.coulomb).initial / max(longest, np.finfo(float).tiny)
    stiffness = base.parameter(roles.stiffness)
    lower = float(np.clip(softest, stiffness.lower, stiffness.initial))
    return base.with_parameters({roles.stiffness: {"lower": lower}})
