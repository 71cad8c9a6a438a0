"""Propose the run that separates rivals best: winning and rival `Solution`s in, `Proposal` out.

1. Lay out a grid of cosine and sweep torques within what was already used.
2. Simulate each torque with the winner; its readings stand for the truth.
3. Refit every rival to these readings and to all existing runs together, to first order. The remaining ‖r‖² is the
   evidence against the rival.
4. Choose the torque that separates the least separated rival in the fewest repeats.

This is T-optimality. The refit matters: an inertia answers as 1/ω² and a lag does not, so two frequencies may separate
what one does not.

References
----------
Atkinson and Fedorov 1975.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from haptid.discrepancy.fit.solution import Solution, under_noise, with_starts
from haptid.discrepancy.fit.tangent_space import movable
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """A torque offset + A·cos(φ(t)) from rest, with the evidence that is expected of it.

    Parameters
    ----------
    amplitude, offset
        Amplitude and offset of the torque in ``unit``.
    frequency, end_frequency
        φ' at the start and at the end [rad/s], with ln φ' linear in time; equal for a cosine.
    duration
        Length of the run [s].
    evidence
        Expected twice the difference of log-likelihoods by one such run beside the existing ones.
    repeats
        Number of such runs that separate the rivals; more than `most_repeats` where `most_repeats` do not.
    rows
        Number of readings of the run.
    unit
        Unit of the torque, N m or N.
    """

    amplitude: float
    frequency: float
    end_frequency: float
    offset: float
    duration: float
    rows: int
    evidence: float = 0.0
    repeats: int = THRESHOLDS.verdict.most_repeats + 1
    unit: str = "N m"

    @property
    def separation(self) -> float:
        """RMS of the readings' difference that a rival cannot reproduce, over the noise."""
        return math.sqrt(max(self.evidence, 0.0) / self.rows)

    @property
    def tells(self) -> bool:
        """Whether at most `most_repeats` such runs separate the rivals."""
        return self.repeats <= THRESHOLDS.verdict.most_repeats

    def torque(self, t: Array) -> Array:
        """Return the torque of the run.

        Parameters
        ----------
        t
            Times [s], shape (n_t,).

        Returns
        -------
        ndarray
            Torque in ``unit``, shape (n_t,).
        """
        growth = math.log(self.end_frequency / self.frequency) / self.duration
        # The phase of a sweep is ω·(e^(g·t) − 1)/g, whose limit for no growth is ω·t.
        phase = self.frequency * (t if growth == 0.0 else np.expm1(growth * t) / growth)
        return np.asarray(self.offset + self.amplitude * np.cos(phase))

    def as_json(self) -> dict[str, float | int | bool | str]:
        """Convert to ``next_experiment`` of the finding's JSON: the run in SI units and in words.

        Returns
        -------
        dict
            Torque, frequencies, duration and row spacing of the run, ``repeats``, whether it ``tells`` the rivals
            apart, the evidence that is expected of it, and the sentence ``run``.
        """
        swept = self.end_frequency != self.frequency
        frequency = (
            f"swept from {self.frequency:.3g} to {self.end_frequency:.3g}" if swept else f"at {self.frequency:.3g}"
        )
        words = (
            f"cosine torque of {self.amplitude:.3g} {self.unit} {frequency} rad/s about {self.offset:.3g} {self.unit}, "
            f"from rest, {self.duration:.3g} s"
        )
        if not self.tells:
            words += f"; it separates them by {self.separation:.2g} of the noise, no run within these limits would do"
        elif self.repeats > 1:
            words += f", {self.repeats} times: one alone separates them by {self.separation:.2g} of the noise"
        return {
            "torque_amplitude_Nm": self.amplitude, "frequency_rad_s": self.frequency,
            "end_frequency_rad_s": self.end_frequency, "torque_offset_Nm": self.offset, "duration_s": self.duration,
            "row_spacing_s": self.duration / (self.rows - 1),
            "repeats": min(self.repeats, THRESHOLDS.verdict.most_repeats), "tells": self.tells,
            "expected_evidence": self.evidence, "separation_over_noise": self.separation, "run": words,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Rival:
    """A rival with what the existing runs say about its parameters: ‖R·δ + told‖² for their change δ.

    Parameters
    ----------
    solution
        Optimum of the rival.
    free
        Indices in x of its parameters that can move, shape (m,).
    R
        Triangle of the Jacobian's QR decomposition, with the runs' initial states projected off, shape (m, m).
    told
        Readings of the winner minus those of the rival in the same coordinates, shape (m,).
    """

    solution: Solution
    free: NDArray[np.intp]
    R: Array
    told: Array


def propose(study: Study, winners: Sequence[Solution], rivals: Sequence[Solution]) -> Proposal:
    """Propose the run that separates the least separated rival from the winner in the fewest repeats.

    Parameters
    ----------
    study
        Study of the fits.
    winners
        The winning model and its variants, each of which may be the truth.
    rivals
        Models that predict as well. A rival counts by its distance from the nearest winner.

    Returns
    -------
    Proposal
        Run of fewest repeats, and of most evidence among these, that stays within the travel (within
        `largest_excursion_over_travel`). Where every run leaves the travel, the run that leaves it least.
    """
    worlds = [(winner, [_rival(study, winner, r) for r in rivals]) for winner in winners]
    template = max(study.fitted, key=lambda run: run.t[-1])
    tried = map_threads(
        partial(_evaluate_proposal, study, worlds, template), _grid(study, template), threads=study.threads
    )
    inside = [p for p, excursion in tried if excursion <= THRESHOLDS.verdict.largest_excursion_over_travel]
    return max(inside or [min(tried, key=lambda pair: pair[1])[0]], key=lambda p: (-p.repeats, p.evidence))


def _grid(study: Study, template: Run) -> list[Proposal]:
    """Return the torques that are tried, at the times of ``template``."""
    largest = max(float(np.abs(run.u).max()) for run in study.fitted)
    fastest = max(find_cycles(run).omega for run in study.fitted)
    limit = 2 * np.pi / (THRESHOLDS.verdict.least_rows_per_period * float(np.median(np.diff(template.t))))
    # Torques no faster than those used are always tried; faster ones only as far as the readings resolve them.
    speeds = [
        fastest * f for f in THRESHOLDS.verdict.proposed_frequencies_over_fastest if fastest * f <= limit or f <= 1.0
    ]
    return [
        Proposal(
            amplitude=a * largest, frequency=slow, end_frequency=fast, offset=o * largest,
            duration=float(template.t[-1]), rows=template.t.size, unit=unit_for("N m", template.prismatic),
        )
        for a, o in THRESHOLDS.verdict.proposed_amplitudes_and_offsets
        for slow, fast in combinations_with_replacement(speeds, 2)
    ]  # fmt: skip


def _rival(study: Study, winner: Solution, rival: Solution) -> _Rival:
    """Reduce the existing runs to their information on a rival's parameters."""
    there, own = (_readings(study, s) for s in (winner, rival))
    problem = rival.problem
    weights = [root / run.sensor_std[0] for root, run in zip(problem.roots, study.fitted, strict=True)]
    pairs = zip(problem.whiteners, weights, there, own, strict=True)
    difference = np.concatenate([whiten((weight * (a - b))[:, None]).ravel() for whiten, weight, a, b in pairs])
    J = rival.blocks.jacobian
    difference = np.pad(difference, (0, J.shape[0] - difference.size))
    places = np.flatnonzero(movable(rival))
    free, starts = places[places < problem.n_parameters], places[places >= problem.n_parameters]
    # With the initial states first, the rows of the triangle below theirs hold the information that is left once each
    # run may begin anew.
    _, triangle = np.linalg.qr(np.column_stack([J[:, starts], J[:, free], difference]))
    below = triangle[starts.size : starts.size + free.size, starts.size :]
    return _Rival(rival, free, below[:, :-1], below[:, -1])


def _readings(study: Study, solution: Solution) -> list[Array]:
    """Simulate every fitted run at an optimum; return readings of shape (n_t,)."""
    simulator = study.factory(solution.equations)
    pairs = zip(study.fitted, solution.x0, strict=True)
    return [simulator.simulate(solution.theta, run, x0=x0).y[:, 0] for run, x0 in pairs]


def _evaluate_proposal(
    study: Study, worlds: Sequence[tuple[Solution, Sequence[_Rival]]], template: Run, proposal: Proposal
) -> tuple[Proposal, float]:
    """Return a proposal with its evidence, and the share of the travel by which the run leaves the travel."""
    told, farthest = [], 0.0
    for winner, rivals in worlds:
        made, excursion = _simulate_proposal(study, winner, template, proposal)
        if not math.isfinite(excursion):
            return proposal, np.inf
        farthest = max(farthest, excursion)
        at = study.fitted.index(template)
        told += [_evidence(study, rival, made, rival.solution.x0[at]) for rival in rivals]
    evidence = np.min(told, axis=0)
    enough = np.flatnonzero(evidence >= THRESHOLDS.verdict.clear_evidence)
    repeats = int(enough[0]) + 1 if enough.size else THRESHOLDS.verdict.most_repeats + 1
    return replace(proposal, evidence=float(evidence[0]), repeats=repeats), farthest


def _simulate_proposal(study: Study, winner: Solution, template: Run, proposal: Proposal) -> tuple[Run, float]:
    """Simulate a proposal; return the run, and the share of the travel by which it leaves the travel.

    The run has the times and the initial state of ``template``, the longest run.
    """
    torque = proposal.torque(template.t)[:, None]
    silent = template.but(file="proposed", u=torque, v=None, extra={}, score_from=0)
    x0 = winner.x0[study.fitted.index(template)]
    y = study.factory(winner.equations).simulate(winner.theta, silent, x0=x0).y
    travelled = np.concatenate([run.y[:, 0] for run in study.fitted])
    excursion = max(travelled.min() - y.min(), y.max() - travelled.max()) / max(np.ptp(travelled), 1e-12)
    return silent.but(y=y), float(excursion)


def _evidence(study: Study, rival: _Rival, run: Run, x0: Array) -> Array:
    """Return the evidence of 1, 2, … runs against a rival that is refitted to all runs, shape (`most_repeats`,).

    The evidence is the least ‖r‖² to first order. It is not proportional to the number of runs: a parameter that the
    existing runs hardly determine can absorb the difference in one run, but not in several.
    """
    solution = rival.solution
    simulator = study.factory(solution.equations)
    problem = under_noise(simulator, (run,), solution.noise, solution.theta, (x0,))
    blocks = problem.blocks(with_starts(problem, problem.unknowns_at(solution.theta), (x0,)))
    if blocks.jacobians is None or not np.isfinite(blocks.residual).all():
        return np.zeros(THRESHOLDS.verdict.most_repeats)
    n = problem.n_parameters
    J = blocks.jacobians[0][:, 0]
    m, starts = rival.free.size, problem.size - n
    _, new = np.linalg.qr(np.column_stack([J[:, rival.free], J[:, n:], blocks.rows[0][:, 0]]))
    there = np.column_stack([rival.R, np.zeros((m, starts)), rival.told])
    # k equal runs weigh as one run times √k.
    repeats = range(1, THRESHOLDS.verdict.most_repeats + 1)
    return np.array([_least_norm(np.vstack([there, math.sqrt(k) * new])) for k in repeats])


def _least_norm(rows: Array) -> float:
    """Return the least ‖A·δ + b‖² over δ for rows [A, b]."""
    A = rows[:, :-1] / np.maximum(np.linalg.norm(rows[:, :-1], axis=0), 1e-300)
    left = rows[:, -1] - A @ np.linalg.lstsq(A, rows[:, -1], rcond=1e-12)[0]
    return float(left @ left)
