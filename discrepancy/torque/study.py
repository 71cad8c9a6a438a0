"""Define the study of one joint under position control: `Campaign` in, `TorqueStudy` out, motion in and torque out.

Where a campaign has no run to validate on, stretches of the run are held out that alternate with fitted ones. A sweep
there and back then shows every held-out position once more, in the other direction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.inverse_dynamics import inverse_equations
from haptid.identification.sequence.equations_for import device_of, equations_for
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, measured_motion, torque_run
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import Equations
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.noise.correlation import Whitener

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Masked(Whitener):
    """Whitener of white noise that sets held-out rows to zero.

    Parameters
    ----------
    seen
        Whether each row is fitted, shape (n_t,).
    """

    seen: Mask

    def __call__(self, x: Array) -> Array:
        """Return x, of shape (n_t, 1) or (n_t, 1, k), with zeros in held-out rows."""
        return np.where(self.seen.reshape(-1, *(1,) * (x.ndim - 1)), x, 0.0)


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
    """

    joint: int
    runs: tuple[Run, ...]
    seen: tuple[Mask, ...]
    base: Equations
    prismatic: bool

    @property
    def whiteners(self) -> tuple[Masked, ...]:
        """One whitener for every run."""
        return tuple(Masked(seen=seen) for seen in self.seen)

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
        """Return the equations of the nominal model with ``effects``."""
        return joint_equations(
            self.joint, parameters=self.base.parameters, effects=effects, prismatic=self.prismatic,
            friction=self.base.friction[0],
        )  # fmt: skip

    def simulator(self, effects: Sequence[Effect] = ()) -> TorqueSimulator:
        """Build the simulator from measured motion to torque.

        Parameters
        ----------
        effects
            Effects in SI units that are `inverse_dynamics.readable`.

        Returns
        -------
        TorqueSimulator
            Simulator of the nominal model with ``effects``.

        Raises
        ------
        ValueError
            If the equations cannot be read from motion to torque.
        """
        inverse = inverse_equations(self.equations(effects))
        if inverse is None:
            msg = f"{[e.key for e in effects]} cannot be read from motion to torque"
            raise ValueError(msg)
        return TorqueSimulator(inverse, CompiledKernel.of(inverse, step=THRESHOLDS.torque.inner_step_s))

    def scales(self, values: Mapping[str, float]) -> Scales:
        """Return the joint's scales over its runs, at fitted parameters ``values`` by id."""
        q = np.concatenate([run.u[:, 0] for run in self.runs])
        v = np.concatenate([measured_motion(run)[:, 1] for run in self.runs])
        roles = law_named(self.base.friction[0]).roles
        return Scales(
            torque=max(float(np.abs(run.y).max()) for run in self.runs), position=float(np.ptp(q)) / 2,
            centre=float(q.max() + q.min()) / 2, speed=float(np.quantile(np.abs(v), 0.99)), inertia=values["inertia"],
            friction=values[roles.coulomb], viscous=values[roles.viscous],
            duration=max(float(run.t[-1]) for run in self.runs), prismatic=self.prismatic,
        )  # fmt: skip


def torque_study_of(campaign: Campaign, joint: int) -> TorqueStudy:
    """Build the study of one joint whose runs were recorded under position control.

    Parameters
    ----------
    campaign
        Campaign whose runs free this joint alone.
    joint
        Number of the joint.

    Returns
    -------
    TorqueStudy
        Study with held-out rows: the runs to validate on, or alternating stretches of runs that are used for both.
    """
    fitted, unseen = campaign.runs_of((joint,), "fit"), campaign.runs_of((joint,), "validate")
    # A file with both uses was divided in time; here its rows alternate instead, so that held-out stretches lie all
    # over it.
    cut = {run.file for run in fitted} & {run.file for run in unseen}
    runs = [*(run for run in fitted if run.file not in cut), *unseen]
    seen = [run.use == "fit" if run.file not in cut else alternating(run.t.size) for run in runs]
    return TorqueStudy(
        joint=joint,
        # The masks hold rows out, so the runs themselves are scored from the first row on.
        runs=tuple(torque_run(run.but(score_from=0)) for run in runs),
        seen=tuple(np.broadcast_to(np.asarray(s), run.t.shape) for s, run in zip(seen, runs, strict=True)),
        base=equations_for(campaign, device_of(campaign), (joint,)),
        prismatic=bool(fitted[0].prismatic[0]),
    )


def alternating(rows: int) -> Mask:
    """Return which rows are fitted, shape (rows,): all but those of every third stretch."""
    stretch = np.arange(rows) * THRESHOLDS.torque.stretches_per_run // rows
    last = THRESHOLDS.torque.stretches_per_held_out_one - 1
    return np.asarray(stretch % THRESHOLDS.torque.stretches_per_held_out_one != last)
