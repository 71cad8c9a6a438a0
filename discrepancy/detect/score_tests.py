"""Score every catalogue effect on the residual of a fit: `Solution` and `Signatures` in, `Scan` out.

1. Project the whitened residual r and the signatures D off the tangent space of the fitted model.
2. At every shape, compute T = rᵀD(DᵀD)⁻¹Dᵀr, with the amplitudes within their bounds. Without model discrepancy T is χ²
   with as many degrees of freedom as D has columns.
3. Keep the best shape of every effect.
4. Judge the smallest p over all effects and shapes by its distribution under white noise, which depends on the Gram
   matrix of all signatures alone (`familywise`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.detect.chi_squared import log_tail
from haptid.discrepancy.detect.detectable import Detectable, smallest
from haptid.discrepancy.detect.familywise import by_sign_flips, independent_tests
from haptid.discrepancy.detect.signatures import Point, Signatures
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.fit.tangent_space import tangent_space
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """The best shape of one catalogue effect.

    Parameters
    ----------
    point
        Shape with the smallest p.
    T
        Score statistic.
    dof
        Degrees of freedom of T.
    log_p
        Logarithm of the p-value of this one test.
    family_p
        Family-wise p-value under the noise model.
    flipped_p
        Family-wise p-value by random signs of the residual's stretches; None where they were not drawn.
    amplitude
        Linear estimate of the factor on each column's values.
    survives
        Share of the signature's norm that the fitted model cannot reproduce.
    others
        Next best shapes of the same effect, each as (point, T, amplitude).
    """

    point: Point
    T: float
    dof: int
    log_p: float
    family_p: float
    flipped_p: float | None
    amplitude: tuple[float, ...]
    survives: float
    others: tuple[tuple[Point, float, tuple[float, ...]], ...] = ()

    @property
    def key(self) -> str:
        """Key of the effect."""
        return self.point.key


@dataclass(frozen=True, slots=True, kw_only=True)
class Scan:
    """Scores of the whole catalogue.

    Parameters
    ----------
    scores
        Best score of every effect, smallest p first.
    tests
        Number of independent tests of the catalogue.
    detectable
        Smallest detectable size of every effect.
    """

    scores: tuple[Score, ...]
    tests: float
    detectable: tuple[Detectable, ...] = ()

    @property
    def family_p(self) -> float:
        """Smallest family-wise p-value of the catalogue; 1 where nothing was scored."""
        return self.scores[0].family_p if self.scores else 1.0


def project(study: Study, solution: Solution, found: Signatures) -> tuple[Array, Array, Array]:
    """Project residual and signatures off the tangent space of a fitted model.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.
    found
        Signatures of the catalogue.

    Returns
    -------
    r, D, survives
        Projected residual (n_r,), projected whitened signatures (n_r, n_columns), and the share of each signature's
        norm that survives (n_columns,).
    """
    Q = tangent_space(solution)
    r = solution.residual
    D = np.zeros((r.size, found.raw.shape[1]))
    D[: found.raw.shape[0]] = found.whiten(study, solution)
    before = np.linalg.norm(D, axis=0)
    D -= Q @ (Q.T @ D)
    r = r - Q @ (Q.T @ r)
    return r, D, np.linalg.norm(D, axis=0) / np.maximum(before, 1e-300)


def _statistics(G: Array, c: Array, point: Point, effect: Effect) -> tuple[float, Array]:
    """Return T at the best amplitudes within the effect's bounds, and these amplitudes as factors on the columns."""
    block, right = G[point.columns, point.columns], c[point.columns]
    amplitude = np.linalg.lstsq(block, right, rcond=1e-10)[0]
    rows = effect.parameters[: len(point.values)]
    limits = [sorted((q.lower / v[q.id], q.upper / v[q.id])) for q, v in zip(rows, point.values, strict=True)]
    low, high = np.array(limits).T
    # Clipping the joint optimum may lose most of T where one amplitude leaves its bounds; each amplitude alone is then
    # better.
    alone = np.diag(right / np.maximum(np.diag(block), 1e-300))
    tried = [np.clip(a, low, high) for a in (amplitude, *alone)]
    gains = [float(2 * a @ right - a @ block @ a) for a in tried]
    best = int(np.argmax(gains))
    return max(gains[best], 0.0), tried[best]


def scan(
    study: Study, solution: Solution, found: Signatures, catalogue: Mapping[str, Effect], *, tests: float | None = None
) -> Scan:
    """Score every catalogue effect at every shape, and keep the best shape of each.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.
    found
        Signatures of the catalogue.
    catalogue
        Catalogue effects by key, in SI units.
    tests
        Number of independent tests. Where None, it is found by draws, and p-values by random signs are computed too.

    Returns
    -------
    Scan
        Scores of all effects with a visible signature.
    """
    r, D, survives = project(study, solution, found)
    c, G = D.T @ r, D.T @ D
    visible = [p for p in found.points if survives[p.columns].max() > THRESHOLDS.detect.least_share_off_tangent_space]
    count = independent_tests(G, visible) if tests is None else tests
    flipped = by_sign_flips(r, D, G, visible, study.fitted) if tests is None else {}
    best: dict[str, list[tuple[float, Point, float, tuple[float, ...]]]] = {}
    for point in visible:
        T, amplitude = _statistics(G, c, point, catalogue[point.key])
        p = log_tail(T, len(point.values), solution.noise.arma.freedom)
        best.setdefault(point.key, []).append((p, point, T, tuple(map(float, amplitude))))
    scores = [
        _score(sorted(rows, key=lambda row: row[0]), count, survives, flipped.get(key)) for key, rows in best.items()
    ]
    # Where p underflows for several effects, T still orders them.
    ordered = tuple(sorted(scores, key=lambda s: (s.log_p, -s.T)))
    return Scan(scores=ordered, tests=count, detectable=smallest(visible, G, count, catalogue))


def _score(
    rows: list[tuple[float, Point, float, tuple[float, ...]]], tests: float, survives: Array, flipped: float | None
) -> Score:
    log_p, point, T, amplitude = rows[0]
    family = float(-np.expm1(tests * np.log1p(-min(float(np.exp(log_p)), 1 - 1e-16))))
    return Score(
        point=point,
        T=T,
        dof=len(point.values),
        log_p=log_p,
        family_p=family,
        flipped_p=flipped,
        amplitude=amplitude,
        survives=float(survives[point.columns].max()),
        others=tuple((other, t, a) for _, other, t, a in rows[1:4]),
    )
