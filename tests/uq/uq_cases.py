"""One small joint, driven by cosines, with a known truth: the smallest problem on which everything can be tried."""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.noise.noise_model import NoiseModel
from haptid.noise.terms import prepare
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.density.density import Density
from haptid.uq.density.forward import KernelForward, kernel_of

TRUTH = {
    "inertia": 1.1e-4,
    "gravity_cos": 0.0,
    "gravity_sin": 0.0,
    "Kp": 1.0,
    "Ks": 0.015,
    "epos": -0.03,
    "sigma0": 0.52,
    "sigma1": 2.2e-3,
    "sigma2": 1.9e-3,
    "vs": 0.066,
    "Fs": 1.33e-3,
    "Fc": 1.05e-3,
}
FREE = ("inertia", "Ks", "epos", "sigma2", "Fc")
NOISE = 2e-4


def make_equations() -> Equations:
    """Five free parameters with priors of 10 %, the others known."""
    changes = {}
    for name, value in TRUTH.items():
        changes[name] = {"initial": value, "fixed": name not in FREE}
        if name in FREE:
            changes[name]["prior"] = Normal(mean=value, std=0.1 * abs(value))
    return joint_equations(4).with_parameters(changes)


def make_run(
    equations: Equations, *, amplitude: float = 5e-3, omega: float = 3.0, rows: int = 400, seed: int = 0,
    s: float = 0.0, use: str = "fit",
) -> Run:  # fmt: skip
    """Simulate a run of 8 s with noise and a cycle-amplitude scatter of the reading."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 8.0, rows)
    u = amplitude * np.cos(omega * t)[:, None]
    theta = np.array([q.initial for q in equations.parameters])
    kernel = CompiledKernel.of(equations)
    y = kernel.simulate(t, u, theta, [TRUTH["epos"], 0.0, 0.0])[:, 0]
    cycle = np.floor(omega * t / (2 * np.pi) + 1e-9).astype(int)
    factors = 1 + s * rng.standard_normal(cycle.max() + 1)
    y = TRUTH["epos"] + (y - TRUTH["epos"]) * factors[cycle] + NOISE * rng.standard_normal(rows)
    return Run(
        file=f"made_{seed}.csv", free_joints=(4,), t=t, u=u, y=y[:, None], noise=np.array([NOISE]),
        resolution=np.zeros(1), posture=np.empty(0), use=use,
    )  # fmt: skip


def make_density(model: NoiseModel, runs: tuple[Run, ...], equations: Equations) -> Density:
    """Density linearised at the truth."""
    coordinates = Coordinates.of(equations, hyper=model.hyper(noise_width=0.05, travel=0.4))
    density = Density(
        coordinates=coordinates, model=model, terms=tuple(prepare(equations, run) for run in runs),
        forward=KernelForward(equations=equations, step=2.5e-3),
    )  # fmt: skip
    return density.linearise(kernel_of(equations), truth_eta(density))


def truth_eta(density: Density) -> np.ndarray:
    theta = np.array([q.initial for q in density.equations.parameters])
    return density.coordinates.eta(theta)
