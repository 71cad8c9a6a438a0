"""One joint with Coulomb and viscous friction and a constant torque, integrated by SciPy, as a run."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from haptid.measurement.values.run import Run

TRUE = {"inertia": 0.05, "gravity_sin": 0.8, "Fv": 0.03, "Fc": 0.12, "offset": 0.05}


def torque_at(t: float, seed: int) -> float:
    phase = 0.7 * seed
    return 0.4 * np.sin(2.0 * t + phase) + 0.25 * np.sin(5.3 * t) + 0.2 * np.sin(9.1 * t + phase)


def plain_run(seed: int, *, use: str = "fit", noise: float = 1e-4, seconds: float = 20.0) -> Run:
    """Integrate a joint with Coulomb and viscous friction by SciPy, smooth over 1e-3 rad/s."""
    t = np.arange(0.0, seconds, 2e-3)

    def rate(t: float, x: np.ndarray) -> list[float]:
        q, v = x
        load = TRUE["gravity_sin"] * np.sin(q) + TRUE["Fv"] * v + TRUE["Fc"] * np.tanh(v / 1e-3) + TRUE["offset"]
        return [v, (torque_at(t, seed) - load) / TRUE["inertia"]]

    q = solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0], t_eval=t, method="LSODA", rtol=1e-8, atol=1e-10).y[0]
    return Run(
        file=f"run_{seed}.csv",
        free_joints=(0,),
        t=t,
        u=np.array([[torque_at(x, seed)] for x in t]),
        y=(q + noise * np.random.default_rng(seed).standard_normal(t.size))[:, None],
        noise=[noise],
        resolution=[0.0],
        posture=np.zeros(0),
        use=use,
        hold="linear",
    )
