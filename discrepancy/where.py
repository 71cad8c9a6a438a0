"""Where the gap lies: residual energy above the noise over time, position, speed, torque and frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from measurement.run import Array, Run

BINS = 12
"""Bins of equal width per variable."""
SHARE = 0.5
"""Share of the gap that a region must hold to be named."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """A contiguous range of one variable that holds ``share_of_gap`` of the gap, in ``share_of_rows`` of the rows."""

    variable: str
    lower: float
    upper: float
    share_of_gap: float
    share_of_rows: float

    def as_json(self) -> dict[str, object]:
        """Fields of INTERFACES, with the share of rows beside them."""
        return {
            "variable": self.variable, "from": self.lower, "to": self.upper,
            "share_of_gap": self.share_of_gap, "share_of_rows": self.share_of_rows,
        }  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Map:
    """Excess of residual energy over the noise per bin of one variable; edges are (BINS + 1,), the rest (BINS,)."""

    variable: str
    edges: Array
    excess: Array
    rows: Array


def maps(runs: Sequence[Run], simulated: Sequence[Array]) -> tuple[Map, ...]:
    """Return the energy maps of measured minus simulated, in squares of the sensor's standard deviation."""
    kept = [run.scored for run in runs]
    energy = np.concatenate(
        [((run.y[:, 0] - y) / run.sensor_std[0])[k] ** 2 for run, y, k in zip(runs, simulated, kept, strict=True)]
    )
    variables = {
        "position_rad": list(simulated),
        "velocity_rad_s": [np.gradient(y, run.t) for run, y in zip(runs, simulated, strict=True)],
        "torque_Nm": [run.u[:, 0] for run in runs],
        "time_s": [run.t for run in runs],
    }
    return tuple(
        _map(name, np.concatenate([v[k] for v, k in zip(values, kept, strict=True)]), energy)
        for name, values in variables.items()
    )


def _map(name: str, values: Array, energy: Array) -> Map:
    edges = np.linspace(values.min(), max(values.max(), values.min() + 1e-12), BINS + 1)
    index = np.clip(np.digitize(values, edges) - 1, 0, BINS - 1)
    rows = np.bincount(index, minlength=BINS).astype(float)
    excess = np.bincount(index, weights=energy - 1.0, minlength=BINS).astype(float)
    return Map(variable=name, edges=edges, excess=excess, rows=rows)


def excess(found: Sequence[Map]) -> float:
    """Return all of the energy above the noise."""
    return float(found[0].excess.sum())


def regions(found: Sequence[Map]) -> tuple[Region, ...]:
    """Return for every variable the narrowest run of bins with at least half of the gap; the most telling first."""
    regions = [r for m in found if (r := _narrowest(m)) is not None]
    return tuple(sorted(regions, key=lambda r: r.share_of_rows - r.share_of_gap))


def _narrowest(m: Map) -> Region | None:
    total = float(np.maximum(m.excess, 0.0).sum())
    if total <= 0.0:
        return None
    share = np.concatenate(([0.0], np.cumsum(np.maximum(m.excess, 0.0)))) / total
    rows = np.concatenate(([0.0], np.cumsum(m.rows))) / max(float(m.rows.sum()), 1.0)
    pairs = [(b - a, a, b) for a in range(BINS) for b in range(a + 1, BINS + 1) if share[b] - share[a] >= SHARE]
    _, a, b = min(pairs, key=lambda p: (rows[p[2]] - rows[p[1]], p))
    return Region(
        variable=m.variable, lower=float(m.edges[a]), upper=float(m.edges[b]),
        share_of_gap=float(share[b] - share[a]), share_of_rows=float(rows[b] - rows[a]),
    )  # fmt: skip
