"""Run the first stages of the search, each alone: `Study` in, `Staged` out.

The stages are whether there is a model discrepancy (``gap``), where it lies (``where``), and which catalogue effects
resemble it (``what``). All of them need only the nominal fit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from haptid.discrepancy.detect.localise import Map, Region, describe_regions, regions
from haptid.discrepancy.detect.omnibus import Omnibus, omnibus
from haptid.discrepancy.detect.score_tests import Scan
from haptid.discrepancy.finding.finding import Curve, curves_of, most_missed
from haptid.discrepancy.fit.held_out import predict
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.search.nominal_model import fit_nominal_model, score_catalogue, under_own_noise
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.support.linear_algebra import rms
from haptid.support.listener import Progress
from haptid.support.numbers import plain
from haptid.support.processes.threads import on_one_thread

Stage = Literal["gap", "where", "what"]
"""Name of a stage."""
STAGES: tuple[Stage, ...] = ("gap", "where", "what")


@dataclass(frozen=True, slots=True, kw_only=True)
class Staged:
    """Result of one stage about the nominal model.

    Parameters
    ----------
    stage
        The stage.
    study
        Study at its inner step.
    plain
        Nominal model under its own noise.
    left
        Omnibus test of its residual.
    curves
        Runs with their simulation, held-out ones where there are any.
    maps, regions, joint
        Residual energy and its regions in the joint where it is largest; empty but in the stage ``where``.
    scan
        Scores of the catalogue; None but in the stage ``what``.
    """

    stage: Stage
    study: Study
    plain: Solution
    left: Omnibus
    curves: tuple[Curve, ...]
    maps: tuple[Map, ...] = ()
    regions: tuple[Region, ...] = ()
    joint: int = 0
    scan: Scan | None = None

    @property
    def discrepant(self) -> bool:
        """Whether the omnibus test finds more than noise in the residual."""
        return bool(self.left.p <= THRESHOLDS.candidate.lack_p_value)

    def as_json(self, *, measured: bool) -> dict[str, Any]:
        """Return the content of ``discrepancy/joint<j>_<stage>.json``.

        Parameters
        ----------
        measured
            Whether the data were measured, not simulated.

        Returns
        -------
        dict
            Gap, omnibus tests, noise model, regions of the residual and, where the catalogue was scored, its scores.
        """
        each = self.scan.scores if self.scan else ()
        scores = [{"id": s.key, "score": s.T, "dof": s.dof, "p": s.family_p, "p_sign_flips": s.flipped_p} for s in each]
        return {
            "schema": "discrepancy_stage/1", "stage": self.stage, "joints": list(self.study.fitted[0].free_joints),
            "measured": measured, "sentence": self.sentence, "gap": self.discrepant, "omnibus_p": self.left.p,
            "tests": dict(self.left.parts),
            "amplitude_scatter": max((one.size for one in self.plain.noise.scatters), default=0.0),
            "white_noise": bool(self.plain.noise.arma.white),
            "where": [r.as_json() | {"joint": self.joint} for r in self.regions], "scores": scores,
        }  # fmt: skip

    @property
    def sentence(self) -> str:
        """Sentence that states the result of the stage."""
        if self.scan is not None:
            found = [
                f"{s.key} (p = {s.family_p:.2g})"
                for s in self.scan.scores[: THRESHOLDS.finding.most_scores_listed]
                if s.family_p < THRESHOLDS.candidate.family_wise_p_value
            ]
            none = "No effect of the catalogue looks like what is left."
            return f"Looks like what is left, before any refit: {', '.join(found)}." if found else none
        if self.maps and self.discrepant:
            return " ".join((self._amount, *describe_regions(self.regions, self.study.fitted[0].prismatic)))
        return f"{self._amount} {self._kind}".rstrip()

    @property
    def _amount(self) -> str:
        left = np.concatenate([(c.run.y[:, 0] - c.before)[c.run.scored] / c.run.sensor_std[0] for c in self.curves])
        over = plain(rms(left), 3)
        missed = f"the nominal model misses these runs by {over} times the sensor's noise"
        return f"There is a gap (p = {self.left.p:.2g}): {missed}." if self.discrepant else f"No gap is seen: {missed}."

    @property
    def _kind(self) -> str:
        noise = self.plain.noise
        if self.discrepant:
            repeats = (
                min(self.left.parts["repeating"], self.left.parts["drifting"]) <= THRESHOLDS.candidate.lack_p_value
            )
            varies = " Part of it differs from cycle to cycle." if noise.scatters else ""
            return f"It {'repeats' if repeats else 'does not repeat'} with the drive.{varies}"
        told = []
        for one in noise.scatters:
            whose = "" if self.study.alone else f" of joint {self.study.fitted[0].free_joints[one.column]}"
            told.append(f"Amplitudes{whose} scatter from cycle to cycle, {100 * one.size:.2g} % (random).")
        if not noise.arma.white:
            told.append("Neighbouring samples of the noise are correlated.")
        return " ".join(told)


@on_one_thread
def run_stages(study: Study, stage: Stage, *, seed: int, starts: int, tell: Progress) -> Staged:
    """Run one stage of one study.

    Parameters
    ----------
    study
        Study of one joint, or of several that move together.
    stage
        ``gap``, ``where`` or ``what``.
    seed
        Seed of the starts.
    starts
        Number of starts of the nominal fit.
    tell
        Told of each step.

    Returns
    -------
    Staged
        Result of the stage.

    Raises
    ------
    NumericalError
        If no start of the nominal fit gives a finite simulation.
    """
    study, base = fit_nominal_model(study, seed=seed, starts=starts, tell=tell)
    _, plain = under_own_noise(study, base)
    seen, unseen = (predict(study, plain, runs).y for runs in (study.fitted, study.unseen))
    runs, y = (study.unseen, unseen) if study.unseen else (study.fitted, seen)
    maps: tuple[Map, ...] = ()
    joint, found = study.fitted[0].free_joints[0], None
    if stage == "where":
        joint, maps = most_missed((*study.fitted, *study.unseen), (*seen, *unseen))
    if stage == "what":
        found = score_catalogue(study, plain, tell)[2]
    left = omnibus(study, plain)
    return Staged(
        stage=stage, study=study, plain=plain, left=left, curves=curves_of(runs, y, y), maps=maps,
        regions=regions(maps) if left.p <= THRESHOLDS.candidate.lack_p_value else (), joint=joint, scan=found,
    )  # fmt: skip
