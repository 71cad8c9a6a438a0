"""Define the study of several joints that move together: `Campaign` and catalogue in, `CoupledStudy` out.

Every joint has catalogue effects of its own. An effect in joint 3 has the id ``joint3_<id>``, and its parameters carry
the suffix ``_3``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from haptid.discrepancy.study.channels import alone
from haptid.discrepancy.study.sealed import seal
from haptid.discrepancy.study.study import Study, scales_over, within_reach
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.algebra.trig_polynomials import position_symbol
from haptid.model.device.device import Device
from haptid.model.effects.effect import Effect, relabel
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import law_named
from haptid.model.joint.coupled_joints import coupled_equations
from haptid.model.joint.joint_in_device import of_the_test_alone
from haptid.model.rigid_body.locked_dynamics import LockedDynamics, locked_motion
from haptid.support.errors import InputError

_motions: dict[tuple[str, tuple[int, ...], tuple[float, ...]], LockedDynamics] = {}
_formulas: dict[tuple[object, ...], Equations] = {}


@dataclass(frozen=True, slots=True, kw_only=True)
class CoupledStudy(Study):
    """A study of several joints: ``joint3_cogging`` is a catalogue effect, ``cogging_sin_3`` a parameter.

    Parameters
    ----------
    joints
        Numbers of the free joints.
    device
        Device to which the joints belong.
    posture
        Position of every joint of the device [rad] in which the other joints are locked.
    known
        Effects by joint, in SI units, that the tests of each joint alone have named; they are part of the nominal
        model.
    most
        Largest number of catalogue effects that are begun on top of a model; None for no limit.
    """

    joints: tuple[int, ...]
    device: Device
    posture: tuple[float, ...]
    known: Mapping[int, Sequence[Effect]] = field(default_factory=dict)
    most: int | None = THRESHOLDS.study.most_coupled_effects_begun

    @property
    def name(self) -> str:
        """Name of the model, for example ``joints01``."""
        return f"joints{''.join(map(str, self.joints))}"

    @property
    def title(self) -> str:
        """Title of the study, for example ``Joints 0, 1``."""
        return f"Joints {', '.join(map(str, self.joints))}"

    @property
    def motion(self) -> LockedDynamics:
        """Equation of motion of the free joints; it is derived once per process."""
        key = (repr(self.device), self.joints, self.posture)
        if key not in _motions:
            _motions[key] = locked_motion(self.device, self.joints, self.posture)
        return _motions[key]

    def equations(self, effects: Sequence[Effect] = (), *, joint: int = 0) -> Equations:
        """Return the equations of the nominal model with ``effects``, each in its own joint.

        Parameters
        ----------
        effects
            Effects in SI units, as `place_in_joint` names them.
        joint
            Not used; it keeps the signature of `Study.equations`.

        Returns
        -------
        Equations
            Equations whose first guess of each inertia is the one at the first guesses with all joints at 0.

        Raises
        ------
        InputError
            Where an effect needs a slot that its joint's friction law lacks.
        """
        del joint
        plain = {j: list(self.known.get(j, ())) for j in self.joints}
        for effect in effects:
            if effect.joint is not None:
                plain[effect.joint].append(take_from_joint(effect, effect.joint))
        made = self._formulas({j: found for j, found in plain.items() if found})
        rows = {q.id: q for q in (*self.base.parameters, *(q for e in effects for q in e.parameters))}
        for i, j in enumerate(self.joints):
            rows |= {q.id: q.but(initial=self.inertia(i)) for q in made.parameters if q.id == f"inertia_{j}"}
        return replace(made, parameters=tuple(rows[q.id] for q in made.parameters))

    def _formulas(self, effects: Mapping[int, Sequence[Effect]]) -> Equations:
        keys = tuple((j, e.key) for j, found in effects.items() for e in found)
        key = (repr(self.device), self.joints, self.posture, keys)
        if key not in _formulas:
            _formulas[key] = coupled_equations(self.device, self.motion, effects)
        return _formulas[key]

    def in_si(self, theta: Mapping[str, float]) -> dict[str, Effect]:
        """Convert the catalogue to SI units, once for every joint.

        Parameters
        ----------
        theta
            Fitted parameters of the nominal model by id.

        Returns
        -------
        dict
            Effects by key that the friction law of each joint can take, without the known and the random ones.
        """
        found = {}
        for i, j in enumerate(self.joints):
            scales = self.scales(i, theta)
            known = {e.id for e in self.known.get(j, ())}
            for effect in self.catalogue.values():
                if effect.id not in known and not effect.random and effect.friction_slots <= self.law(i).slots:
                    one = place_in_joint(effect.at(scales), j)
                    found[one.key] = one
        return found

    def in_joint(self, effect: Effect, column: int) -> Effect:
        """Return an effect under the names that it has in the joint at index ``column``.

        Parameters
        ----------
        effect
            Effect of a joint alone.
        column
            Index among the free joints.

        Returns
        -------
        Effect
            Copy whose id and names bear the number of the joint.
        """
        return place_in_joint(effect, self.joints[column])

    def scales(self, i: int, theta: Mapping[str, float]) -> Scales:
        """Return the scales of one joint.

        Parameters
        ----------
        i
            Index of the joint among the free joints.
        theta
            Fitted parameters of the nominal model by id.

        Returns
        -------
        Scales
            Scales in SI units over the fitted runs.
        """
        j = self.joints[i]
        roles = self.law(i).roles
        own = {id: theta[f"{id}_{j}"] for id in ("Kp", roles.coulomb, roles.viscous)}
        return scales_over([alone(run, i) for run in self.fitted], own | {"inertia": self.inertia(i)}, roles)

    def law(self, i: int) -> FrictionLaw:
        """Return the friction law of the joint at index ``i``.

        Parameters
        ----------
        i
            Index among the free joints.

        Returns
        -------
        FrictionLaw
            The law that the device names for the joint.
        """
        return law_named(self.device.joints[self.joints[i]].friction)

    def inertia(self, i: int) -> float:
        """Return the inertia M_ii [kg m²] of the joint at index ``i`` at the first guesses, all joints at 0.

        Parameters
        ----------
        i
            Index among the free joints.

        Returns
        -------
        float
            M_ii [kg m²]; a mass [kg] for a prismatic joint.
        """
        motion = self.motion
        M = motion.mass_matrix[i, i].subs(dict.fromkeys(map(position_symbol, self.joints), 0))
        return float(M.subs({c.symbol: self.base.parameter(c.id).initial for c in motion.coefficients}))


def coupled_study_of(
    campaign: Campaign,
    joints: Sequence[int],
    catalogue: Mapping[str, Effect],
    known: Mapping[int, Sequence[Effect]],
    *,
    threads: int = 1,
) -> CoupledStudy:
    """Build the study of several free joints of a campaign.

    Runs in another posture of the locked joints than that of the first run are left out, because their coefficients
    differ.

    Parameters
    ----------
    campaign
        Campaign of a device.
    joints
        Numbers of the free joints.
    catalogue
        Catalogue effects by key, in multiples of the joints' scales.
    known
        Effects by joint, in SI units, that the tests of each joint alone have named.
    threads
        Number of threads that simulate runs side by side.

    Returns
    -------
    CoupledStudy
        Study with the known effects in its nominal model, their parameters fixed.

    Raises
    ------
    InputError
        If the campaign has no run of these joints to fit, if its device is a single joint, or if there are more than
        `most_joints` joints.
    """
    joints = tuple(joints)
    fitted, device = campaign.runs_of(joints, "fit"), device_of(campaign)
    where = f"--free {','.join(map(str, joints))}"
    if not fitted or device is None:
        got = "single_joint" if device is None else "no such run"
        raise InputError(where, expected="runs to fit of a device with these joints free", got=got)
    if len(joints) > THRESHOLDS.study.most_joints:
        raise InputError(
            where, expected=f"runs to fit with at most {THRESHOLDS.study.most_joints} joints free", got=str(len(joints))
        )
    first = fitted[0]
    posture = tuple(float(x) for x in first.posture)
    locked = _find_locked_posture(first, joints)
    alike = [run for run in campaign.runs_of(joints) if _find_locked_posture(run, joints) == locked]
    fitted = tuple(run for run in alike if run.use == "fit")
    unseen, sealed = seal([run for run in alike if run.use == "validate"])
    base = within_reach(equations_for(campaign, device, joints, posture), fitted)
    held: list[Quantity] = []
    for j, found in known.items():
        for effect in found:
            held += [q.but(fixed=True) for q in place_in_joint(effect, j).parameters]
    base = replace(base, parameters=(*base.parameters, *held))
    study = CoupledStudy(
        joint=joints[0], joints=joints, device=device, posture=posture, fitted=fitted,
        unseen=unseen, sealed=sealed, base=base, known=known,
        catalogue={
            key: e
            for key, e in catalogue.items()
            if e.random or not (of_the_test_alone(e) or e.torque_only or e.series_of)
        },
        noise_given=campaign.noise_given, threads=threads,
    )  # fmt: skip
    return replace(study, base=study.equations())


def _find_locked_posture(run: Run, joints: Sequence[int]) -> tuple[float, ...]:
    """Return the positions of the locked joints."""
    return tuple(float(x) for j, x in enumerate(run.posture) if j not in joints)


def place_in_joint(effect: Effect, joint: int) -> Effect:
    """Rename an effect as one of joint ``joint`` among several.

    Parameters
    ----------
    effect
        Effect of a joint alone.
    joint
        Number of the joint.

    Returns
    -------
    Effect
        Effect whose id, rivals and parameters carry the number of the joint. It has no contenders.
    """
    names = {id: f"{id}_{joint}" for id in effect.own_names}
    return relabel(effect, names).but(
        id=f"joint{joint}_{effect.id}",
        title=f"{effect.title}, joint {joint}",
        rivals=tuple(f"joint{joint}_{id}" for id in effect.rivals),
        contenders=(),
        joint=joint,
    )


def take_from_joint(effect: Effect, joint: int) -> Effect:
    """Undo the renaming of `place_in_joint`; id and parameters lose the number of joint ``joint``.

    Parameters
    ----------
    effect
        Effect that `place_in_joint` has renamed.
    joint
        Number of its joint.

    Returns
    -------
    Effect
        Effect of a joint alone.
    """
    names = {id: id.removesuffix(f"_{joint}") for id in effect.own_names}
    return relabel(effect, names).but(id=effect.id.removeprefix(f"joint{joint}_"), joint=None)
