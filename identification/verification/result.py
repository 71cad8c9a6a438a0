"""What the verification of a whole model found, run by run and joint by joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from haptid.measurement.values.run import Array

Mode = Literal["closed_loop", "open_loop"]
SENTENCES: Mapping[Mode, str] = {
    "closed_loop": "the stated controller closes the loop around the model; given are references and first positions",
    "open_loop": "the recorded torques drive the model without feedback: small errors of torque add up to a drift",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class JointCheck:
    """How one joint of a run is predicted.

    Parameters
    ----------
    joint, prismatic
        Number of the joint, and whether it slides: then rad and N m are m and N below.
    rmse_rad
        RMS of (measured − simulated) [rad]; NaN where the simulation left the finite numbers.
    rmse_over_noise, nrmse
        The same over the sensor noise √(noise² + resolution²/12), and over the range of the measured position.
    torque_difference_Nm, torque_rms_Nm
        RMS of (recorded − simulated torque) and of the recorded torque [N m]; the first is 0 in open loop.
    spread_rad
        RMS over time of the standard deviation between draws of the parameters [rad]; NaN without draws.
    """

    joint: int
    prismatic: bool
    rmse_rad: float
    rmse_over_noise: float
    nrmse: float
    torque_difference_Nm: float
    torque_rms_Nm: float
    spread_rad: float

    @property
    def over_expected(self) -> float:
        """RMS over √(noise² + spread²): about 1 where noise and parameter uncertainty explain the residual."""
        noise = self.rmse_rad / self.rmse_over_noise if self.rmse_over_noise > 0 else 0.0
        return self.rmse_rad / float(np.hypot(noise, self.spread_rad))


@dataclass(frozen=True, slots=True, kw_only=True)
class RunCheck:
    """One run in one mode; ``draws`` counts the parameter draws whose simulation stayed finite."""

    file: str
    use: str
    mode: Mode
    joints: tuple[JointCheck, ...]
    draws: int
    t: Array
    measured: Array
    simulated: Array
    spread: Array

    @property
    def sentence(self) -> str:
        """What was simulated."""
        return SENTENCES[self.mode]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """All runs, each in closed loop where a controller and references are known, and from the recorded torques."""

    runs: tuple[RunCheck, ...]
    law: str = ""
    assumed: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the ``verification`` table of identification.json; what is not finite is null."""
        return {"law": self.law, "assumed": list(self.assumed), "runs": [_run_json(run) for run in self.runs]}


def _run_json(run: RunCheck) -> dict[str, Any]:
    return {
        "file": run.file,
        "use": run.use,
        "mode": run.mode,
        "what": run.sentence,
        "draws": run.draws,
        "joints": [
            {
                "joint": one.joint,
                "rmse_rad": _finite(one.rmse_rad),
                "rmse_over_noise": _finite(one.rmse_over_noise),
                "nrmse": _finite(one.nrmse),
                "torque_difference_Nm": _finite(one.torque_difference_Nm),
                "torque_rms_Nm": _finite(one.torque_rms_Nm),
                "spread_rad": _finite(one.spread_rad),
                "rmse_over_expected": _finite(one.over_expected),
            }
            for one in run.joints
        ],
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
