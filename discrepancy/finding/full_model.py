"""Judge the identified model on runs with all joints free: `Run`s and `Finding`s in, `WholeFinding` out.

No fit saw these runs and nothing is fitted to them. Simulated are the identified model, and the model with the named
effects. Noise and the known uncertainty of the parameters explain the RMS e = √(noise² + spread²) together. A joint
with an RMS above `largest_rms_over_expected`·e has a model discrepancy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from haptid.discrepancy.finding.finding import SCHEMA
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.verdict.verdict import Verdict
from haptid.fmu_build.exchange.discrepancy_json import Finding, apply_refits, by_joint
from haptid.fmu_build.exchange.identification_json import of_device
from haptid.identification.verification.result import JointCheck, Verification
from haptid.identification.verification.verify import verify
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.model.joint.joint_in_device import names_of
from haptid.model.joint.whole_device import full_equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Missed:
    """RMS of measured − simulated of one joint in one run.

    Parameters
    ----------
    file
        File of the run.
    mode
        Mode of the simulation.
    joint
        Number of the joint.
    prismatic
        Whether the joint is prismatic; then all RMS are in m, otherwise in rad.
    before, after
        RMS without and with the named effects.
    noise
        RMS of the sensor noise.
    expected
        RMS that noise and the uncertainty of the parameters explain.
    """

    file: str
    mode: str
    joint: int
    prismatic: bool
    before: float
    after: float
    noise: float
    expected: float

    def as_json(self) -> dict[str, Any]:
        """Convert to an entry of ``gap.validate`` in the JSON of several joints.

        Returns
        -------
        dict
            All fields by name; RMS in rad or m.
        """
        return {name: getattr(self, name) for name in self.__slots__}


@dataclass(frozen=True, slots=True, kw_only=True)
class WholeFinding:
    """Verdict on the runs with all joints free.

    Parameters
    ----------
    joints
        Numbers of the joints.
    verdict
        ``nothing_missing``, ``named`` or ``unlisted``.
    sentence
        Sentence that an engineer reads first.
    names
        Effects that were named in the joints.
    rows
        RMS of every joint in every run.
    """

    joints: tuple[int, ...]
    verdict: Verdict
    sentence: str
    names: tuple[str, ...]
    rows: tuple[Missed, ...]

    def as_json(self, *, measured: bool) -> dict[str, Any]:
        """Return the content of ``discrepancy/whole.json``.

        Parameters
        ----------
        measured
            Whether the data were measured, not simulated.

        Returns
        -------
        dict
            Verdict, names of the effects, and the gap on validation runs in SI units.
        """
        return {
            "schema": SCHEMA, "joint": None, "joints": list(self.joints), "measured": measured, "verdict": self.verdict,
            "sentence": self.sentence, "effects": [{"id": name} for name in self.names],
            "gap": {"validate": [row.as_json() for row in self.rows]},
        }  # fmt: skip


def whole_finding(
    campaign: Campaign,
    device: Device,
    runs: Sequence[Run],
    identification: Mapping[str, Any],
    findings: Sequence[Finding],
) -> WholeFinding:
    """Simulate runs with all joints free, without and with the named effects, and judge their residuals.

    Parameters
    ----------
    campaign
        Campaign that the runs belong to; it may hold the controller.
    device
        Device with all joints.
    runs
        Runs with all joints free.
    identification
        Content of the identification's JSON.
    findings
        Findings of the single joints, whose named effects and refitted parameters are used.

    Returns
    -------
    WholeFinding
        Verdict with the RMS of every joint in every run.

    Raises
    ------
    InputError
        Where two findings are of the same joint, or as `verify`.
    NumericalError
        As `verify`.
    """
    effects, controller = by_joint(findings), campaign.extra.get("controller")
    identified = of_device(identification)
    before = verify(device, identified.among(full_equations(device)).values, runs, controller)
    after = before
    if effects:
        with_them = apply_refits(identified, findings).among(full_equations(device, effects))
        after = verify(device, with_them.values, runs, controller, effects=effects)
    spread = _parameter_spread(identification)
    rows = tuple(
        _residual_rms(*where, one, two, spread.get((*where, one.joint), 0.0))
        for (where, one), (_, two) in zip(_each(before), _each(after), strict=True)
    )
    names = names_of(effects)
    verdict, sentence = _state_verdict(rows, names)
    return WholeFinding(joints=runs[0].free_joints, verdict=verdict, sentence=sentence, names=names, rows=rows)


def _each(found: Verification) -> list[tuple[tuple[str, str], JointCheck]]:
    return [((run.file, str(run.mode)), one) for run in found.runs for one in run.joints]


def _residual_rms(file: str, mode: str, before: JointCheck, after: JointCheck, spread: float) -> Missed:
    noise = before.rmse_rad / before.rmse_over_noise
    expected = float((noise**2 + spread**2) ** 0.5)
    return Missed(
        file=file, mode=mode, joint=before.joint, prismatic=before.prismatic, before=before.rmse_rad,
        after=after.rmse_rad, noise=noise, expected=expected,
    )  # fmt: skip


def _parameter_spread(identification: Mapping[str, Any]) -> dict[tuple[str, str, int], float]:
    """Return the standard deviation of the readings from the parameters' uncertainty [rad], by run, mode and joint."""
    return {
        (run["file"], run["mode"], one["joint"]): float(one["spread_rad"] or 0.0)
        for run in identification.get("verification", {}).get("runs", [])
        for one in run["joints"]
    }


def _state_verdict(rows: Sequence[Missed], names: Sequence[str]) -> tuple[Verdict, str]:
    before = {r.joint for r in rows if r.before > THRESHOLDS.finding.largest_rms_over_expected * r.expected}
    after = {r.joint for r in rows if r.after > THRESHOLDS.finding.largest_rms_over_expected * r.expected}
    with_names = f"with {', '.join(names)}" if names else "no effect was named in its joints"
    if not before and not after:
        return "nothing_missing", "Nothing is missing: noise and the parameters' uncertainty explain these runs."
    if not after:
        return (
            "named",
            f"{_joints(before)}: missed by more than noise and uncertainty explain, no longer {with_names}.",
        )
    return "unlisted", f"{_joints(after)}: missed by more than noise and uncertainty explain; {with_names}."


def _joints(joints: set[int]) -> str:
    return f"Joint{'s' * (len(joints) > 1)} {', '.join(map(str, sorted(joints)))}"
