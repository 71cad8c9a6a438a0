"""The joint of a blind case, and the torques of its runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.machine.variation import vary
from haptid.virtual_device.recording.inputs import Cosine, rich, table3
from studies.hidden.plan import UPRIGHT

WIDTH = 0.2
"""Spread of the machines around the one of the embedded campaign, itself within ±30 % of its design."""
TOLD = ("inertia", "Ks", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")
"""Parameters of which a campaign of a single joint tells the design value."""


def draw_joint(
    joint: int, device: str, rng: np.random.Generator
) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """Draw a joint, and what its campaign tells of it.

    Parameters
    ----------
    joint
        Number of the joint.
    device
        ``single_joint`` or ``freedom6s``.
    rng
        Random generator, which moves on.

    Returns
    -------
    parameters : dict
        Parameters of the joint by name, SI units.
    known : dict
        Entries of ``[joint.<j>.parameters]`` by name; empty for a joint of the built-in device.
    """
    design, home = Arm(read_truth()), np.zeros(JOINTS)
    drawn = Arm(vary(read_truth(), WIDTH, rng)).locked_joint(joint, home)
    if device != "single_joint":
        return drawn, {}
    guess = design.locked_joint(joint, home)
    known = {"Kp": {"fixed": 1.0}} | {name: {"initial": float(f"{guess[name]:.2g}")} for name in TOLD}
    if joint in UPRIGHT:
        return drawn | {"gravity_cos": 0.0, "gravity_sin": 0.0}, known | {
            "gravity_cos": {"fixed": 0.0},
            "gravity_sin": {"fixed": 0.0},
        }
    weight = 2.0 * float(np.hypot(drawn["gravity_cos"], drawn["gravity_sin"]))
    limit = max(0.05 if joint < 3 else 0.005, float(f"{weight:.1g}"))
    bounds = {"initial": 0.0, "lower": -limit, "upper": limit}
    return drawn, known | {"gravity_cos": dict(bounds), "gravity_sin": dict(bounds)}


def fixed_parameters(joint: int, known: Mapping[str, object]) -> tuple[str, ...]:
    """Return the names of the parameters that a fit of a joint may not change.

    Parameters
    ----------
    joint
        Number of the joint.
    known
        What its campaign tells of it, as `draw_joint` returns it.

    Returns
    -------
    tuple of str
    """
    return ("Kp", "gravity_cos", "gravity_sin") if known and joint in UPRIGHT else ("Kp",)


def choose_inputs(joint: int, inputs: str) -> tuple[Cosine, ...]:
    """Return the runs; Table III keeps two for validation, its brackets included.

    Parameters
    ----------
    joint
        Number of the joint.
    inputs
        ``rich`` or ``table3``.

    Returns
    -------
    tuple of Cosine
        One cosine a run.
    """
    if inputs == "rich":
        return rich(joint)
    runs = [replace(run, use="validate", reason="") if run.use == "excluded" else run for run in table3(joint)]
    if sum(run.use == "validate" for run in runs) < 2:
        fastest = max(k for k, run in enumerate(runs) if run.use == "fit")
        runs[fastest] = replace(runs[fastest], use="validate")
    return tuple(runs)
