"""Write the tables of the tutorial: a pendulum with friction, as its logger would have written them. SYNTHETIC.

``python -m docs.from_runs.pendulum_tables`` writes them. SciPy simulates the pendulum from the equations below, and
nothing of haptid takes part, so that the tutorial identifies a truth that is not its own model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from scipy.integrate import solve_ivp

from haptid.support.files.files import write_text
from haptid.support.installing.environment import ROOT

FOLDER = ROOT / "docs" / "tutorial" / "pendulum_tables"
RATE_HZ = 500.0
DURATION_S = 3.0
NOISE_DEG = 0.02
DECIMALS_OF_ANGLE = 3
DECIMALS_OF_TORQUE = 2
SEED = 20261125
TRUTH: Mapping[str, float] = {
    "inertia": 6.2e-3,  # kg m²: 0.25 kg at 0.155 m, and the rod
    "weight": 0.36,  # N m, with the arm level
    "Fc": 0.030,  # N m
    "Fs": 0.042,  # N m
    "vs": 0.25,  # rad/s
    "sigma0": 25.0,  # N m/rad
    "sigma1": 0.12,  # N m s/rad
    "sigma2": 0.008,  # N m s/rad
}
"""What the tutorial's fit has to find again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Test:
    """One run of the pendulum: a cosine torque.

    Parameters
    ----------
    amplitude
        Of the torque [N m].
    omega
        Angular frequency [rad/s].
    """

    amplitude: float
    omega: float


TESTS: Mapping[str, Test] = {
    "run_1": Test(amplitude=0.10, omega=5.5),
    "run_2": Test(amplitude=0.16, omega=6.5),
    "run_3": Test(amplitude=0.30, omega=3.0),
    "val_1": Test(amplitude=0.22, omega=4.2),
}


def simulate(test: Test) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Simulate one run from rest.

    Parameters
    ----------
    test
        Its torque.

    Returns
    -------
    t, torque, angle : ndarray, shape (n_t,)
        In s, N m, held from row to row, and rad, without noise.
    """
    p = TRUTH
    t = np.arange(0.0, DURATION_S, 1.0 / RATE_HZ)
    torque = np.round(test.amplitude * np.cos(test.omega * t) * 1e3, DECIMALS_OF_TORQUE) / 1e3
    state, angle = np.zeros(3), np.zeros(t.size)
    for row, held in enumerate(torque[:-1]):

        def slope(_: float, now: np.ndarray, held: float = held) -> tuple[float, float, float]:
            q, speed, deflection = now
            steady = p["Fc"] + (p["Fs"] - p["Fc"]) * np.exp(-((speed / p["vs"]) ** 2))
            rate = speed - p["sigma0"] * abs(speed) * deflection / steady
            friction = p["sigma0"] * deflection + p["sigma1"] * rate + p["sigma2"] * speed
            return speed, (held - p["weight"] * np.sin(q) - friction) / p["inertia"], rate

        # A solver of its own for each row: the torque jumps there.
        path = solve_ivp(slope, (t[row], t[row + 1]), state, method="LSODA", rtol=1e-9, atol=1e-12)
        state = path.y[:, -1]
        angle[row + 1] = state[0]
    return t, torque, angle


def table(test: Test, seed: int) -> str:
    """Return the logger's text of one run.

    Parameters
    ----------
    test
        Its torque.
    seed
        Of the sensor's noise.

    Returns
    -------
    str
        Time in ms, torque in N mm, angle in degrees.
    """
    t, torque, angle = simulate(test)
    reading = np.degrees(angle) + NOISE_DEG * np.random.default_rng(seed).standard_normal(t.size)
    lines = [
        "# pendulum rig, SYNTHETIC: made by docs/from_runs/pendulum_tables.py",
        "Time (ms),Torque (N mm),Angle (deg)",
    ]
    for row in zip(t * 1e3, torque * 1e3, reading, strict=True):
        time_ms, torque_Nmm, angle_deg = row
        lines.append(f"{time_ms:g},{torque_Nmm:.{DECIMALS_OF_TORQUE}f},{angle_deg:.{DECIMALS_OF_ANGLE}f}")
    return "\n".join(lines) + "\n"


@click.command()
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=FOLDER)
def main(out: Path) -> None:
    """Write one table a run."""
    out.mkdir(parents=True, exist_ok=True)
    for number, (name, test) in enumerate(TESTS.items()):
        click.echo(write_text(out / f"{name}.csv", table(test, SEED + number)))


if __name__ == "__main__":
    main()
