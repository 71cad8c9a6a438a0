"""Effective samples per second: the kernel in lanes against emcee over fmpy.simulate_fmu, same posterior, same run.

Joint 4 of the embedded campaign, its fitted runs, white noise and amplitude scatter. Both sides sample the same density
from the same start; effective samples are steps times walkers over the slowest coordinate's autocorrelation time. The
plain side does what a user of emcee and fmpy would do: stretch moves, one walker at a time, fmpy.simulate_fmu at the
rows' spacing. Its autocorrelation time is measured on the same density, its cost on a few evaluations. Results go to
``docs/results``.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import click
import emcee
import fmpy
import numpy as np

from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.description.variables import structured_name
from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.noise.noise_model import NoiseModel
from haptid.noise.thresholds import THRESHOLDS
from haptid.uq.density.forward import KernelForward, kernel_of
from haptid.uq.density.laplace import Laplace
from haptid.uq.density.solver_step import longest_step
from haptid.uq.prediction.choice import Problem
from haptid.uq.result.infer import QUICK
from haptid.uq.sampling.autocorrelation import autocorrelation_time
from haptid.uq.sampling.sampling import sample
from studies.ledger.version import origin_of, store, tell_origin

OUT = Path(__file__).parents[2] / "docs" / "results" / "effective_samples.json"
PLAIN_EVALUATIONS = 6
PLAIN_STEPS = 500
"""Steps of stretch moves that measure their autocorrelation time; too few make it too small,
in the plain side's favour."""
JOINT = 4


def mode_of_joint() -> tuple[Laplace, tuple[Run, ...]]:
    """Return the posterior's mode, ready to sample."""
    campaign = campaign_for_command(None)
    equations = equations_for(campaign, device_of(campaign), (JOINT,))
    runs = campaign.runs_of((JOINT,))
    theta = np.array(fit(kernel_of(equations), runs, options=FitOptions(method="gauss_newton", starts=2)).theta)
    fitted = tuple(run for run in runs if run.use == "fit")

    def attempt(step: float) -> Laplace:
        forward = KernelForward(equations=equations, step=step)
        problem = Problem(
            simulator=forward.simulator(),
            forward=forward,
            fitted=fitted,
            unseen=(),
            noise_width=THRESHOLDS.stated_noise_log_std,
        )
        return problem.mode(NoiseModel(scatter="reading"), theta)

    return longest_step(attempt, lambda mode: mode)[0], fitted


class FmuForward:
    """`uq.density.forward.Forward` by fmpy.simulate_fmu, one walker after the other."""

    def __init__(self, equations: Equations, folder: Path) -> None:
        self.equations = equations
        self.fmu = str(build_fmu(equations, folder / "joint.fmu", kind="native").path)
        self.description = fmpy.read_model_description(self.fmu)
        self.unzipped = fmpy.extract(self.fmu)

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `uq.density.forward.Forward`."""
        return np.array([self._one(theta, run, x0) for theta in thetas])

    def shortfall(self, thetas: Array, run: Run, x0: Array) -> Array:  # noqa: ARG002 # the protocol's arguments
        """See `uq.density.forward.Forward`: the FMU keeps its own inner step."""
        return np.zeros((len(thetas), run.t.size))

    def _one(self, theta: Array, run: Run, x0: Array) -> Array:
        e = self.equations
        start = {structured_name(e, q.id, q.structured): float(v) for q, v in zip(e.parameters, theta, strict=True)}
        start |= {structured_name(e, s.id, s.structured): float(v) for s, v in zip(e.states, x0, strict=True)}
        torque = structured_name(e, e.inputs[0].id, e.inputs[0].structured)
        reading = structured_name(e, e.outputs[0].id, e.outputs[0].structured)
        signal = np.array(list(zip(run.t, run.u[:, 0], strict=True)), dtype=[("time", float), (torque, float)])
        spacing = float(run.t[1] - run.t[0])
        result: Any = fmpy.simulate_fmu(
            self.unzipped,
            model_description=self.description,
            stop_time=float(run.t[-1]),
            output_interval=spacing,
            step_size=spacing,
            start_values=start,
            input=signal,
            output=[reading],
        )
        return np.asarray(result[reading])


def measure() -> dict[str, Any]:
    """Sample on both sides; return cost and autocorrelation time of each."""
    mode, fitted = mode_of_joint()
    begun = time.perf_counter()
    ours = sample(mode, QUICK)
    spent = time.perf_counter() - begun
    ensembles, steps, walkers = ours.chain.shape[:3]
    with tempfile.TemporaryDirectory() as folder:
        forward = FmuForward(mode.density.equations, Path(folder))
        plain = mode.density.but(forward=forward)
        points = (
            mode.eta + 0.1 * np.random.default_rng(0).standard_normal((PLAIN_EVALUATIONS, mode.eta.size)) @ mode.lower.T
        )
        difference = float(np.abs(plain(points[:2]) - mode.density(points[:2])).max())
        begun = time.perf_counter()
        plain(points)
        each = (time.perf_counter() - begun) / PLAIN_EVALUATIONS
    sampler = emcee.EnsembleSampler(walkers, mode.eta.size, mode.density, vectorize=True)
    sampler.random_state = np.random.RandomState(0).get_state()
    sampler.run_mcmc(ours.chain[0, -1], PLAIN_STEPS)
    tau = float(autocorrelation_time(sampler.get_chain()[None]).max())
    return {
        "coordinates": int(mode.eta.size),
        "fitted_runs": len(fitted),
        "rows": [int(run.t.size) for run in fitted],
        "log_densities_differ_by": difference,
        "lanes": {
            "ensembles": ensembles,
            "steps": steps,
            "walkers": walkers,
            "move": ours.move,
            "wall_s": spent,
            "autocorrelation_time": float(ours.tau.max()),
            "effective_samples_per_s": float(ours.effective.min()) / spent,
        },
        "plain": {
            "evaluations": PLAIN_EVALUATIONS,
            "steps": PLAIN_STEPS,
            "density_s": each,
            "autocorrelation_time": tau,
            "effective_samples_per_s": 1 / (each * tau),
        },
    }


def page(stored: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    lanes, plain = stored["lanes"], stored["plain"]
    ratio = lanes["effective_samples_per_s"] / plain["effective_samples_per_s"]
    lines = [
        "# Effective samples per second",
        "",
        f"Joint {JOINT} of the embedded campaign, {stored['fitted_runs']} fitted runs of {max(stored['rows'])} rows, "
        f"white noise and amplitude scatter, {stored['coordinates']} coordinates. Both sides sample the same density "
        "from the same mode in one process; an autocorrelation time is that of the slowest coordinate.",
        "",
        tell_origin(stored),
        "",
        "| | autocorrelation time [steps] | effective samples per second |",
        "| --- | ---: | ---: |",
        f"| `uq`: kernel in lanes, {lanes['move']} proposals, burn-in counted | {lanes['autocorrelation_time']:.1f} | "
        f"{lanes['effective_samples_per_s']:.1f} |",
        f"| emcee's stretch move over `fmpy.simulate_fmu`, {1e3 * plain['density_s']:.0f} ms per density | "
        f"{plain['autocorrelation_time']:.0f} | {plain['effective_samples_per_s']:.2g} |",
        "",
        f"Ratio {ratio:.0f}. The two log densities differ by {stored['log_densities_differ_by']:.2g}, which is the "
        "coarse inner step. The plain side's autocorrelation time is measured on the same density by the kernel over "
        f"{plain['steps']} steps, its cost on {plain['evaluations']} evaluations.",
    ]
    return "\n".join(lines) + "\n"


@click.command(help=__doc__)
def main() -> None:
    """Measure, and write results and page."""
    measured = measure()
    stored = {**origin_of("python -m benchmarks.posteriors.effective_samples"), **measured}
    click.echo(store(OUT, stored, page))


if __name__ == "__main__":
    main()
