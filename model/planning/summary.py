"""The locking plan as JSON-ready data: the content of `locking_plan.json` and the source of pages and tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from haptid.model.device.device import STANDARD, Device, Guess
from haptid.model.planning.lock_postures import PosturePlan
from haptid.model.planning.locking_order import LockingOrder, Stage
from haptid.model.planning.torque_design import ExcitationPlan
from haptid.model.rigid_body.base_parameters import base_parameters, numeric_rank
from haptid.model.rigid_body.inertial_parameters import pi_ids, standard_ids
from haptid.model.rigid_body.locked_dynamics import locked_motion

Data = dict[str, Any]


def plan_summary(device: Device, order: LockingOrder) -> Data:
    """Summarise the locking order of a device.

    Parameters
    ----------
    device
        Device of the plan.
    order
        Locking order of the device.

    Returns
    -------
    dict
        JSON-ready data of schema ``locking_plan/1``: stages, base parameters and what is not identifiable.
    """
    joints = tuple(range(len(device.joints)))
    names = pi_ids(device)
    found = base_parameters(order.full)
    rank, _ = numeric_rank(device, joints)
    per_joint = [sum(not guess.fixed for guess in joint.parameters.values()) for joint in device.joints]
    return {
        "schema": "locking_plan/1",
        "device": device.name,
        "title": device.title,
        "assumptions": list(device.assumptions),
        "software": {name: version(name) for name in ("sympy", "numpy")},
        "locking_order": [list(stage.free) for stage in order.stages],
        "stages": [_stage(device, stage, per_joint) for stage in order.stages],
        "parameters": [key for key in standard_ids(device) if key in order.needed],
        "base_parameters": {
            "count": order.full.rank,
            "rank_exact": order.full.rank,
            "rank_numeric": rank,
            "reached_with_locked_joints_at_home": order.reached_home,
            "reached_with_locked_joints_anywhere": order.reached_any,
            "formulas": [parameter.text(names) for parameter in found],
        },
        "unknowns_at_once": len(order.needed) + sum(per_joint),
        "largest_stage": max(len(stage.new) + _joint_unknowns(stage, order, per_joint) for stage in order.stages),
        "unidentifiable": _unidentifiable(device, order),
    }


def design_summary(excitations: Sequence[ExcitationPlan | str], postures: PosturePlan) -> Data:
    """Summarise the proposed runs and lock postures.

    Parameters
    ----------
    excitations
        Plan of each joint, or the reason why the joint has no plan.
    postures
        Proposed lock postures.

    Returns
    -------
    dict
        JSON-ready data with the keys ``excitation`` and ``postures``.
    """
    return {
        "excitation": [
            {"joint": joint, "reason": one} if isinstance(one, str) else _excitation(one)
            for joint, one in enumerate(excitations)
        ],
        "postures": {
            "tests": [
                {"free_joints": list(test.dynamics.joints), "locked_positions_rad": list(test.dynamics.posture)}
                for test in postures.chosen
            ],
            "coefficient_accuracy": postures.accuracy,
            "torque_error_first_guesses": postures.error_prior,
            "torque_error_home": postures.error_home,
            "torque_error_planned": postures.error_planned,
        },
    }


def _excitation(plan: ExcitationPlan) -> Data:
    return {
        "joint": plan.joint,
        "runs": [
            {
                "amplitude_Nm": run.amplitude,
                "frequency_rad_s": run.omega,
                "travel_rad": run.travel,
                "presliding_share": run.presliding,
            }
            for run in plan.chosen
        ],
        "expected": [
            {
                "id": one.id,
                "unit": one.unit,
                "initial": one.initial,
                "std_before": float(before),
                "std_after": float(after),
            }
            for one, before, after in zip(plan.parameters, plan.std_plain, plan.std_chosen, strict=True)
        ],
        "warnings": list(plan.warnings),
    }


def _joint_unknowns(stage: Stage, order: LockingOrder, per_joint: list[int]) -> int:
    earlier = {j for other in order.stages[: order.stages.index(stage)] for j in other.free}
    return sum(per_joint[j] for j in stage.free if j not in earlier)


def _stage(device: Device, stage: Stage, per_joint: list[int]) -> Data:
    dynamics = locked_motion(device, stage.free)
    names = pi_ids(device)
    sort = standard_ids(device).index
    return {
        "free_joints": list(stage.free),
        "contains": sorted(stage.contains, key=sort),
        "new": sorted(stage.new, key=sort),
        "joint_parameters": sum(per_joint[j] for j in stage.free) if len(stage.free) == 1 else 0,
        "equation": {
            "mass_matrix": [[str(entry) for entry in row] for row in dynamics.mass_matrix.tolist()],
            "gravity_force": [str(entry) for entry in dynamics.gravity_force],
        },
        "coefficients": [
            {
                "id": one.id,
                "unit": one.unit,
                "description": one.description,
                "initial": one.initial,
                "prior_std": one.prior_std,
                "of": {names[k]: float(factor) for k, factor in sorted(one.exact.items())},
            }
            for one in dynamics.coefficients
        ],
        "combinations_at_home": stage.rank_home,
        "combinations_anywhere": stage.rank_any,
        "new_combinations": stage.new_combinations,
    }


def _unidentifiable(device: Device, order: LockingOrder) -> list[Data]:
    names = pi_ids(device)
    reached = {key for stage in order.stages for key in stage.contains}
    alone = {names[p.leading] for p in base_parameters(order.full) if len(p.factors) == 1}
    result: list[Data] = [
        {
            "what": [f"Kp of joint {j}" for j, joint in enumerate(device.joints) if _free_gain(joint.parameters)]
            or ["the common factor of Kp, inertia, gravity, spring and friction of each joint"],
            "why": "Commands are torques, measurements are positions: multiplying Kp, inertia, gravity, spring and "
            "friction of a joint by one factor leaves its motion as it is. Kp is fixed, or held by a prior.",
        }
    ]
    for link in device.massive:
        never = [f"link{link.name}_{key}" for key in STANDARD if f"link{link.name}_{key}" not in order.needed]
        if never:
            result.append(
                {
                    "what": never,
                    "why": f"No equation contains them: link {link.name} never moves so that they act.",
                }
            )
    missing = sorted(order.needed - reached)
    if missing:
        result.append({"what": missing, "why": "They act in the full model, but in none of the planned tests."})
    combined = [name for name in names if _contains(order, name, names) and name not in alone]
    if combined:
        result.append(
            {"what": combined, "why": "Only the combinations listed as base parameters can be told, at any posture."}
        )
    lost = order.full.rank - order.reached_home
    if lost:
        result.append(
            {
                "what": [f"{lost} of {order.full.rank} base parameters"],
                "why": "With the locked joints at home in every test these are not reached; other lock postures reach "
                f"{order.reached_any} of {order.full.rank}.",
            }
        )
    return result


def _free_gain(parameters: Mapping[str, Guess]) -> bool:
    return "Kp" in parameters and not parameters["Kp"].fixed


def _contains(order: LockingOrder, name: str, names: tuple[str, ...]) -> bool:
    return names.index(name) in order.full.columns
