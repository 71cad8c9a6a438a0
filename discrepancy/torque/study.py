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
from haptid.identification.fit.torque_fit import restrain_stribeck
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, invertible, measured_motion, torque_runs
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.effects.effect import Effect
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import Equations
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations

Mask = NDArray[np.bool_]


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
            Effects in SI units that are `readable`.

        Returns
        -------
        TorqueSimulator
            Simulator of the nominal model with ``effects``.

        Raises
        ------
        ValueError
            If the equations cannot be read from motion to torque.
        """
        return TorqueSimulator.of(self.equations(effects), step=THRESHOLDS.torque.inner_step_s)

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
    # The masks hold rows out, so the runs themselves are scored from the first row on.
    turned = torque_runs([run.but(score_from=0) for run in runs])
    seen = [run.use == "fit" if run.file not in cut else alternating(run.t.size) for run in turned]
    stated = tuple(campaign.parameter_overrides.get(joint, {}))
    return TorqueStudy(
        joint=joint,
        runs=turned,
        seen=tuple(np.broadcast_to(np.asarray(s), run.t.shape) for s, run in zip(seen, turned, strict=True)),
        base=restrain_stribeck(equations_for(campaign, device_of(campaign), (joint,)), fitted, stated),
        prismatic=bool(fitted[0].prismatic[0]),
    )


def alternating(rows: int) -> Mask:
    """Return which rows are fitted, shape (rows,): all but those of every third stretch."""
    stretch = np.arange(rows) * THRESHOLDS.torque.stretches_per_run // rows
    last = THRESHOLDS.torque.stretches_per_held_out_one - 1
    return np.asarray(stretch % THRESHOLDS.torque.stretches_per_held_out_one != last)


def readable(entries: Mapping[str, Effect], base: Equations, *, prismatic: bool) -> dict[str, Effect]:
    """Return the catalogue effects whose equations can be read from motion to torque.

    Parameters
    ----------
    entries
        Catalogue effects by key.
    base
        Equations of the nominal model.
    prismatic
        Whether the joint is prismatic.

    Returns
    -------
    dict
        Effects by key.
    """
    joint, law = base.joints[0], law_named(base.friction[0])
    kept = {}
    for key, effect in entries.items():
        # These sides act on the path of the torque or of the reading; leaving them out first saves building their
        # equations.
        if effect.random or effect.side in ("output", "time", "input"):
            continue
        if effect.friction_slots - law.slots:
            continue
        extended = joint_equations(
            joint, parameters=base.parameters, effects=[effect], prismatic=prismatic, friction=law.id
        )
        if invertible(extended):
            kept[key] = effect
    return kept
