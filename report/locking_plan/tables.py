"""Tables of the locking plan, for page and terminal: summary of `model.plan` in, rows of text out."""

from __future__ import annotations

from typing import Any

Data = dict[str, Any]


def configuration(joints: list[int]) -> str:
    """Write the free joints of a configuration, as in ``4`` or ``0+1``.

    Parameters
    ----------
    joints
        Numbers of the free joints.

    Returns
    -------
    str
        Numbers joined by ``+``.
    """
    return "+".join(str(j) for j in joints)


def ones(plan: Data) -> list[list[str]]:
    """Return the table of ones.

    Parameters
    ----------
    plan
        Content of the plan's JSON file.

    Returns
    -------
    list of rows
        One row per parameter of the full model: its name, then ``1`` in the configuration that first contains it.
    """
    return [[key, *("1" if key in stage["new"] else "" for stage in plan["stages"])] for key in plan["parameters"]]


def locking_table(plan: Data) -> list[list[str]]:
    """Return one row per configuration: number, then L (locked) or U (unlocked) for each joint.

    Parameters
    ----------
    plan
        Locking plan, as its JSON file has it.

    Returns
    -------
    list of list of str
        Cells; configurations count from 1, and the joints are those that some configuration frees.
    """
    joints = sorted({j for stage in plan["stages"] for j in stage["free_joints"]})
    return [
        [str(n), *("U" if j in stage["free_joints"] else "L" for j in joints)]
        for n, stage in enumerate(plan["stages"], start=1)
    ]


def counts(plan: Data) -> list[list[str]]:
    """Return one row per configuration: free joints, parameters contained, new ones, combinations.

    Parameters
    ----------
    plan
        Locking plan, as its JSON file has it.

    Returns
    -------
    list of list of str
        Cells: free joints, parameters contained, new ones, parameters of the joints, combinations at home,
        anywhere, and new ones.
    """
    return [
        [
            configuration(stage["free_joints"]),
            str(len(stage["contains"])),
            str(len(stage["new"])),
            str(stage["joint_parameters"]),
            str(stage["combinations_at_home"]),
            str(stage["combinations_anywhere"]),
            str(stage["new_combinations"]),
        ]
        for stage in plan["stages"]
    ]


COUNTS_HEADER = (
    "free joints",
    "inertial parameters in it",
    "new ones",
    "friction, spring, gain",
    "combinations at home",
    "combinations over postures",
    "new combinations",
)


RUNS_HEADER = ["joint", "runs"]
ERRORS_HEADER = ["joint", "parameter", "first guess", "before", "after", "unit"]
NO_POSTURES = "No lock postures beyond home are proposed."
POSTURES_HEADER = ["free joints", "locked at [rad or m] (- free)"]


def run_rows(plan: Data) -> list[list[str]]:
    """Return one row per joint: its proposed runs (amplitude [N m] at frequency [rad/s]), or why there are none.

    Parameters
    ----------
    plan
        Locking plan, as its JSON file has it.

    Returns
    -------
    list of list of str
        Cells: joint, and its runs or the reason.
    """
    return [
        [
            str(one["joint"]),
            one.get("reason")
            or ", ".join(f"{run['amplitude_Nm']:.3g} at {run['frequency_rad_s']:.3g}" for run in one["runs"]),
        ]
        for one in plan["excitation"]
    ]


def error_rows(plan: Data) -> list[list[str]]:
    """Return one row per joint and parameter: first guess, expected standard error before and after.

    Parameters
    ----------
    plan
        Locking plan, as its JSON file has it.

    Returns
    -------
    list of list of str
        Cells: joint, parameter, first guess, standard error before and after, unit of the three.
    """
    return [
        [
            str(one["joint"]),
            p["id"],
            f"{p['initial']:.3g}",
            f"{p['std_before']:.2g}",
            f"{p['std_after']:.2g}",
            p["unit"],
        ]
        for one in plan["excitation"]
        for p in one.get("expected", [])
    ]


def posture_rows(plan: Data) -> list[list[str]]:
    """Return one row per proposed test: free joints, and positions of the locked ones [rad or m], - for a free one.

    Parameters
    ----------
    plan
        Locking plan with ``postures``, as its JSON file has it.

    Returns
    -------
    list of list of str
        Cells: free joints, and one text with the positions of all joints.
    """
    return [
        [
            configuration(test["free_joints"]),
            ", ".join(
                "-" if j in test["free_joints"] else f"{x:+.3f}" for j, x in enumerate(test["locked_positions_rad"])
            ),
        ]
        for test in plan["postures"]["tests"]
    ]


def posture_sentence(plan: Data) -> str:
    """Say by how much the proposed postures reduce the expected torque error of the full model.

    Parameters
    ----------
    plan
        Locking plan with ``postures``, as its JSON file has it.

    Returns
    -------
    str
        Expected errors [%] from the first guesses, after the tests at home, and with the proposed postures.
    """
    found = plan["postures"]
    return (
        f"Expected torque error of the full model (rms over rms, coefficients fitted to "
        f"{100 * found['coefficient_accuracy']:.2g} %): {100 * found['torque_error_first_guesses']:.2g} % from the "
        f"first guesses, {100 * found['torque_error_home']:.2g} % after the tests at home, "
        f"{100 * found['torque_error_planned']:.2g} % with the proposed postures."
    )
