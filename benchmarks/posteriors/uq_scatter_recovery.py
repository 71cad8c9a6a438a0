"""Recovery of the amplitude scatter: true s of 0, 2, 5, 10 %, on the torque or on the measured amplitude.

Joint 4 of the virtual device, six cosines of 16 s to fit and two unseen, 0.2 mrad noise, 0.15 mrad encoder steps.
The noise model is chosen by the unseen runs, as the command does.
The posterior is its normal approximation at the mode.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.noise.thresholds import THRESHOLDS
from haptid.uq.density.forward import KernelForward
from haptid.uq.prediction.choice import Problem, best, compare
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import rich

JOINT = 4
STEP = 2.5e-3
"""Inner step [s]; what it leaves out at the mode is taken off."""
TRUTHS = (0.0, 0.02, 0.05, 0.10)


def recovered(folder: Path, s: float, *, on_torque: bool, seed: int) -> str:
    """Make a campaign with this scatter, read it, and say what was found."""
    parameters = Arm(read_truth()).locked_joint(JOINT, np.zeros(6))
    effects = {"amplitude_scatter": {"scatter": s, "scatter_on_torque": float(on_torque)}} if s > 0 else {}
    inputs = rich(JOINT)
    make_joint_campaign(
        folder, JOINT, parameters, (*inputs[:6], *inputs[8:10]), effects=effects, seed=seed, known=known()
    )
    campaign = campaign_for_command(folder)
    equations = equations_for(campaign, None, (JOINT,))
    runs = campaign.runs_of((JOINT,))
    fitted = tuple(run for run in runs if run.use == "fit")
    forward = KernelForward(equations=equations, step=STEP)
    simulator = forward.simulator()
    theta = np.array(fit(simulator, runs, options=FitOptions(method="gauss_newton", starts=3)).theta)
    problem = Problem(
        simulator=simulator,
        forward=forward,
        fitted=fitted,
        unseen=tuple(run for run in runs if run.use == "validate"),
        noise_width=THRESHOLDS.stated_noise_log_std,
    )
    scored = compare(problem, theta)
    chosen = best(scored)
    wanted = "torque" if on_torque else "reading"
    asked = next(one for one in scored if one.model.id == wanted)
    names = asked.mode.density.coordinates.names
    i = names.index("cycle_scatter")
    value, width = float(np.exp(asked.mode.eta[i])), float(np.sqrt(asked.mode.covariance[i, i]))
    low, high = value * np.exp(-1.96 * width), value * np.exp(1.96 * width)
    return f"{100 * value:8.3f} %  ({100 * low:.3f} to {100 * high:.3f} %, 95 %)   chosen: {chosen.model.id}"


def known() -> dict[str, dict[str, float]]:
    """Return what the campaign tells of the parameters: the plant gain."""
    return {"Kp": {"fixed": 1.0}}


def main() -> None:
    """Print one line per true scatter."""
    print(f"{'true s':>8s}  acts on   posterior of s under the model in which it acts there")
    with tempfile.TemporaryDirectory() as folder:
        for k, s in enumerate(TRUTHS):
            for on_torque in (False, True) if s > 0 else (False,):
                found = recovered(Path(folder) / f"{k}{on_torque}", s, on_torque=on_torque, seed=10 + k)
                print(f"{100 * s:6.0f} %  {'torque ' if on_torque else 'reading'}   {found}", flush=True)


if __name__ == "__main__":
    main()
