"""The stated problem, on two joints: LuGre, 6 s, 1,201 samples, nine free parameters, starts up to threefold off.

The data come from the virtual device, whose equations and integrator belong to no contestant. A fit sees the run
``fit``; the run ``validate``, at other frequencies, only judges. Every contestant knows that a run starts at rest at
q = 0 with a relaxed bristle and that torque is held between rows.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from haptid.virtual_device.machine.joint import integrate

Array = NDArray[np.float64]
Cosines = tuple[tuple[float, float], ...]

NAMES = ("inertia", "Ks", "epos", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")
"""The free parameters; gravity does no work and Kp = 1 is known."""
NOISE = 2e-4
"""Standard deviation of the white sensor noise [rad]."""
SAMPLES, SPACING = 1201, 0.005
START_FACTOR, BOUND_FACTOR = 3.0, 10.0
"""Starts are log-uniform within the first factor of the truth, bounds lie at the second."""
SEED = 20261121
THRESHOLD = 1.05
"""A start has reached the truth where the RMS on the validation run is at most this many noise standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One joint: nine true parameters in the order of `NAMES` (SI units), and cosines [N m], [rad/s] of its runs."""

    title: str
    truth: tuple[float, ...]
    cosines: Mapping[str, Cosines]

    def torque(self, run: str) -> Array:
        """Return the torque at the rows of ``run`` [N m], shape (1201,)."""
        return np.asarray(sum(a * np.cos(w * times()) for a, w in self.cosines[run]))

    def simulate(self, theta: Array, run: str) -> Array:
        """Return positions without noise [rad], shape (1201,), by the virtual device's integrator."""
        return integrate(dict(zip(NAMES, map(float, theta), strict=True)), times(), self.torque(run))[2]

    def readings(self, run: str) -> Array:
        """Return readings of ``run`` [rad], shape (1201,): noise on all rows but the first (zeroed there)."""
        y = self.simulate(np.array(self.truth), run)
        rng = np.random.default_rng([SEED, list(self.cosines).index(run)])
        return np.asarray(y + NOISE * rng.standard_normal(y.shape) * (np.arange(y.size) > 0))

    def starts(self, count: int) -> Array:
        """Return the first ``count`` points of a Sobol sequence, log-uniform within threefold, shape (count, 9)."""
        unit = qmc.Sobol(len(NAMES), seed=SEED).random_base2(int(np.ceil(np.log2(max(count, 2)))))[:count]
        return np.asarray(np.array(self.truth) * START_FACTOR ** (2.0 * unit - 1.0))

    def judge(self, theta: Array | None, run: str = "validate") -> float:
        """Return RMS over noise of the parameters (9,) on ``run``; infinite where there are none."""
        if theta is None or not np.all(np.isfinite(theta)):
            return float("inf")
        residual = self.readings(run) - self.simulate(np.asarray(theta), run)
        return float(np.sqrt(np.mean(residual[1:] ** 2)) / NOISE)

    def statement(self, count: int) -> dict[str, object]:
        """Return what every contestant is told."""
        return {
            "names": list(NAMES),
            "lower": [p / BOUND_FACTOR for p in self.truth],
            "upper": [p * BOUND_FACTOR for p in self.truth],
            "starts": self.starts(count).tolist(),
            "noise": NOISE,
            "cosines": self.cosines["fit"],
            "t": times().tolist(),
            "u": self.torque("fit").tolist(),
            "y": self.readings("fit").tolist(),
        }

    def write(self, path: Path, count: int) -> Path:
        """Write the statement with ``count`` starts as JSON."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(self.statement(count)), encoding="utf-8")
        return path


def times() -> Array:
    """Return the times of the rows [s], shape (1201,)."""
    return np.asarray(np.round(np.arange(SAMPLES) * SPACING, 6))


CASES = {
    "two_cosines": Case(
        title="a direct-drive joint under two cosines",
        truth=(1e-3, 0.02, 0.02, 1.0, 0.01, 1e-3, 0.05, 3e-3, 2e-3),
        cosines={"fit": ((0.012, 2.5), (0.006, 6.1)), "validate": ((0.007, 2.0), (0.004, 5.2))},
    ),
    "one_cosine": Case(
        title="a light tendon-driven joint under one cosine of Table III",
        truth=(2.5e-4, 0.015, 0.03, 0.5, 3e-3, 1.5e-3, 0.06, 1.5e-3, 1.2e-3),
        cosines={"fit": ((0.005, 1.75),), "validate": ((0.005, 2.38),)},
    ),
}
"""Round numbers. The validation runs are such that the best possible fit is expected to reach the threshold: from the
Fisher information of the first run, √(1 + mean variance of the prediction/noise²) is 1.01 in both cases."""
