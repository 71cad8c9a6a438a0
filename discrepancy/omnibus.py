"""Is there a gap at all? Energy of the projected residual in the band of motion, whatever its cause."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from discrepancy.harmonics import harmonics
from discrepancy.scan import tangent_space
from discrepancy.solution import Solution
from discrepancy.study import Study


@dataclass(frozen=True, slots=True, kw_only=True)
class Omnibus:
    """Energy of the residual on the harmonics of the drive: χ² with ``dof`` degrees of freedom where noise is left."""

    energy: float
    dof: int
    p: float
    total: float
    rows: int


def omnibus(study: Study, solution: Solution) -> Omnibus:
    """Test the whitened residual on every run's harmonics, projected off what the model can move."""
    cycles = study.cycles()
    edges = np.cumsum([0, *(run.t.size for run in study.fitted)])
    n = solution.residual.size
    Q = tangent_space(solution)
    energy, dof = 0.0, 0
    columns = []
    for run, whiten, a, b in zip(study.fitted, solution.problem.whiteners, edges[:-1], edges[1:], strict=True):
        H = whiten(harmonics(run, cycles[run.file]))
        H[1 : run.score_from] = 0.0
        placed = np.zeros((n, H.shape[1]))
        placed[a:b] = np.linalg.qr(H)[0]
        columns.append(placed)
    B = np.concatenate(columns, axis=1)
    B -= Q @ (Q.T @ B)
    U, d, _ = np.linalg.svd(B.T @ B)
    keep = d > 1e-6
    along = (U[:, keep].T @ (B.T @ solution.residual)) / np.sqrt(d[keep])
    energy, dof = float(along @ along), int(keep.sum())
    return Omnibus(energy=energy, dof=dof, p=float(chi2.sf(energy, dof)), total=solution.chi2, rows=study.rows)
