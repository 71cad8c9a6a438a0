"""Result of the verification of a whole model: `Verification`, by run (`RunCheck`) and joint (`JointCheck`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.thresholds import THRESHOLDS as MODEL

WholeOutcome = Literal["as_noise", "explained", "uncertain", "unexplained", "diverged"]
"""What a verification says of the whole model: noise alone is left; the parameters' uncertainty explains the rest; it
is so large that it would explain anything; it does not explain the rest; the simulation is not finite."""
Mode = Literal["closed_loop", "open_loop"]
SENTENCES: Mapping[Mode, str] = {
    "closed_loop": "the stated controller closes the loop around the model; given are references and first positions",
    "open_loop": "the recorded torques drive the model without feedback: small errors of torque add up to a drift",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class JointCheck:
    """Prediction of one joint of a run.

    Parameters
    ----------
    joint, prismatic
        Number of the joint, and whether it is prismatic: then rad and N m below are m and N.
    rmse_rad
        RMS of (measured − simulated) [rad]; NaN where the simulation is not finite.
    rmse_over_noise, nrmse
        RMS of (measured − simulated) over the sensor noise √(noise² + resolution²/12), and over the range of the
        measured position.
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
        return self.rmse_rad / float(np.hypot(self._noise_rad, self.spread_rad))

    @property
    def spread_over_noise(self) -> float:
        """Spread between draws of the parameters over the sensor noise; NaN without draws."""
        return self.spread_rad / self._noise_rad if self._noise_rad > 0 else float("nan")

    @property
    def _noise_rad(self) -> float:
        """Sensor noise [rad], which follows from two ratios: a check keeps none of its own."""
        return self.rmse_rad / self.rmse_over_noise if self.rmse_over_noise > 0 else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RunCheck:
    """Prediction of one run in one mode.

    Parameters
    ----------
    file, use
        File of the run and its use.
    mode
        Whether the run was simulated in closed or in open loop.
    joints
        Prediction by joint.
    draws
        Number of parameter draws whose simulation is finite.
    t
        Times [s], shape (n_t,).
    measured, simulated, spread
        Positions, and the standard deviation of the draws' positions [rad], shape (n_t, n_joints) each.
    """

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
        """Sentence that says how the run was simulated."""
        return SENTENCES[self.mode]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """Predictions of all runs, in closed loop where controller and references are known, and in open loop.

    Parameters
    ----------
    runs
        Prediction by run and mode.
    law
        Description of the controller in the campaign.
    assumed
        Ids of parameters without an identified value, which keep the device's first guess.
    inner_step
        Inner step that the runs need [s].
    """

    runs: tuple[RunCheck, ...]
    law: str = ""
    assumed: tuple[str, ...] = ()
    inner_step: float = MODEL.inner_step_s

    @property
    def outcome(self) -> WholeOutcome | None:
        """Judgement of the whole model by its worst joint in any run; None where no run was simulated."""
        joints = [joint for run in self.runs for joint in run.joints]
        if not joints:
            return None
        # Written with `not … <`: a NaN of a simulation that is not finite counts as diverged.
        if not all(joint.rmse_over_noise < float("inf") for joint in joints):
            return "diverged"
        if max(joint.rmse_over_noise for joint in joints) <= THRESHOLDS.largest_residual_as_noise:
            return "as_noise"
        if any(joint.over_expected > THRESHOLDS.largest_residual_over_expected for joint in joints):
            return "unexplained"
        # A spread that is not known, as where no draw stays finite, explains nothing either.
        narrow = all(joint.spread_over_noise <= THRESHOLDS.largest_spread_in_noise for joint in joints)
        return "explained" if narrow else "uncertain"

    def as_json(self) -> dict[str, Any]:
        """Convert to the ``verification`` table of identification.json; numbers that are not finite become null.

        Returns
        -------
        dict
            ``law``, ``assumed``, ``outcome`` (null without a run), ``runs`` with one entry for each run and mode, and
            ``inner_step_s`` where the runs need a shorter one than the model's own.
        """
        runs = [_run_json(run) for run in self.runs]
        step = {} if self.inner_step == MODEL.inner_step_s else {"inner_step_s": self.inner_step}
        return {"law": self.law, "assumed": list(self.assumed), "outcome": self.outcome, "runs": runs, **step}


FIGURES: Mapping[Mode, str] = {"closed_loop": "closed_rmse", "open_loop": "free_rmse"}
"""Name of a run's RMS position error in ``figures``, by mode."""


def _run_json(run: RunCheck) -> dict[str, Any]:
    return {
        "file": run.file,
        "use": run.use,
        "mode": run.mode,
        "what": run.sentence,
        "draws": run.draws,
        "figures": {"model": {FIGURES[run.mode]: [_finite(one.rmse_rad) for one in run.joints]}},
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
