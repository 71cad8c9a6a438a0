"""Recovery of the amplitude scatter: true s of 0, 2, 5, 10 %, on the torque or on the measured amplitude.

Joint 4 of the virtual device, six cosines of 16 s to fit and two unseen, 0.2 mrad noise, 0.15 mrad encoder steps.
The noise model is chosen by the unseen runs, as the command does.
The posterior is its normal approximation at the mode. Results go to ``docs/results``.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import click
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
from studies.ledger.version import origin_of, store, tell_origin

OUT = Path(__file__).parents[2] / "docs" / "results" / "scatter_recovery.json"
JOINT = 4
STEP = 2.5e-3
"""Inner step [s]; what it leaves out at the mode is taken off."""
TRUTHS = (0.0, 0.02, 0.05, 0.10)
Z95 = 1.959964


def recovered(folder: Path, s: float, *, on_torque: bool, seed: int) -> dict[str, Any]:
    """Make a campaign with this scatter, read it, and return what was found, the interval of 95 %."""
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
    factor = float(np.exp(Z95 * width))
    return {
        "true": s,
        "acts_on": wanted,
        "scatter": value,
        "interval": [value / factor, value * factor],
        "chosen": chosen.model.id,
    }


def known() -> dict[str, dict[str, float]]:
    """Return what the campaign tells of the parameters: the plant gain."""
    return {"Kp": {"fixed": 1.0}}


def page(stored: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    lines = [
        "# Recovery of the amplitude scatter",
        "",
        f"Synthetic: joint {JOINT} of the virtual device, six cosines of 16 s to fit and two unseen, 0.2 mrad noise, "
        "0.15 mrad encoder steps. The noise model is chosen by the unseen runs, as the command does; the posterior is "
        "its normal approximation at the mode.",
        "",
        tell_origin(stored),
        "",
        "| true s [%] | acts on | s under the model in which it acts there [%] (95 %) | chosen by held-out score |",
        "| ---: | --- | --- | --- |",
    ]
    held = 0
    for row in stored["rows"]:
        low, high = row["interval"]
        where = row["acts_on"] if row["true"] > 0 else "–"
        held += row["true"] > 0 and low <= row["true"] <= high
        lines.append(
            f"| {100 * row['true']:.0f} | {where} | {100 * row['scatter']:.3g} ({100 * low:.3g} to {100 * high:.3g}) | "
            f"{row['chosen']} |"
        )
    scattered = [row for row in stored["rows"] if row["true"] > 0]
    paths = sum(row["chosen"].startswith(row["acts_on"]) for row in scattered)
    lines += [
        "",
        f"Of {len(scattered)} scatters {held} lie within their interval; the path on which they act is recognised in "
        f"{paths}.",
    ]
    return "\n".join(lines) + "\n"


@click.command(help=__doc__)
def main() -> None:
    """Work through the scatters, and write results and page."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for k, s in enumerate(TRUTHS):
            for on_torque in (False, True) if s > 0 else (False,):
                rows.append(recovered(Path(folder) / f"{k}{on_torque}", s, on_torque=on_torque, seed=10 + k))
                click.echo(f"{100 * s:.0f} % on the {rows[-1]['acts_on']}: {rows[-1]['chosen']}", err=True)
    stored = {**origin_of("python -m benchmarks.posteriors.scatter_recovery"), "rows": rows}
    click.echo(store(OUT, stored, page))


if __name__ == "__main__":
    main()
