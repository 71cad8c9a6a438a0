"""Localise the residual: measured `Run`s and simulated readings in, `Map`s and `Region`s out.

1. Sort the residual's energy above the noise into bins of position, speed, torque, time, cycle, direction, run and
   frequency (`maps`).
2. For every variable, find the narrowest range of bins that holds at least `least_share_of_excess_in_region` of that
   energy (`regions`).
3. Say so in sentences (`describe_regions`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for

AXES = {
    "position_rad": ("position", "rad"), "velocity_rad_s": ("speed", "rad/s"), "torque_Nm": ("drive torque", "N m"),
    "time_s": ("time", "s"), "cycle": ("cycle", ""), "direction": ("direction", ""), "run": ("run", ""),
    "frequency_rad_s": ("frequency [rad/s]", ""),
}  # fmt: skip
"""Variables in words, and their units for a revolute joint."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """A contiguous range of one variable that holds much of the residual's excess energy.

    Parameters
    ----------
    variable
        Key of `AXES`.
    lower, upper
        Ends of the range in the variable's unit. Cycles and runs count from 0, both ends included; a direction is −1 or
        1.
    share_of_gap
        Share of the excess energy in the range.
    share_of_rows
        Share of the rows in the range; of the frequencies for a spectrum.
    files
        Files of the runs, where the variable is the run.
    """

    variable: str
    lower: float
    upper: float
    share_of_gap: float
    share_of_rows: float
    files: tuple[str, ...] = ()

    def as_json(self) -> dict[str, object]:
        """Convert to an entry of ``where`` in the finding's JSON.

        Returns
        -------
        dict
            ``variable``, ``from`` and ``to`` in its unit, ``share_of_gap`` and ``share_of_rows`` [1], and ``files``
            where the variable is the run.
        """
        named = {"files": list(self.files)} if self.files else {}
        return {
            "variable": self.variable, "from": self.lower, "to": self.upper,
            "share_of_gap": self.share_of_gap, "share_of_rows": self.share_of_rows, **named,
        }  # fmt: skip

    def sentence(self, prismatic: Sequence[bool], joint: str = "") -> str:
        """Say how much of the model discrepancy lies where.

        Parameters
        ----------
        prismatic
            Whether each free joint is prismatic, which decides the units.
        joint
            Words that follow the name of a quantity measured at the joint.

        Returns
        -------
        str
            Sentence with the shares of energy and rows in per cent, and the range in the variable's unit.
        """
        rows = "of the spectrum" if self.variable == "frequency_rad_s" else "of the samples"
        share = f"{100 * self.share_of_gap:.0f} % of the gap lies {self._place(prismatic, joint)}"
        part = 100 * self.share_of_rows
        return f"{share}, in {part:.{0 if part >= 1 else 2}f} % {rows}."

    def _place(self, prismatic: Sequence[bool], joint: str) -> str:
        if self.variable == "run":
            return f"in {', '.join(self.files)}"
        if self.variable == "cycle":
            first, last = int(self.lower) + 1, int(self.upper) + 1
            return f"in cycle {first}" if first == last else f"in cycles {first} to {last}"
        if self.variable == "direction":
            moves = {(1.0, 1.0): "grows", (-1.0, -1.0): "falls"}.get((self.lower, self.upper), "grows or falls")
            return f"where the position{joint} {moves}"
        if self.variable == "frequency_rad_s":
            return f"at frequencies between {self.lower:.3g} and {self.upper:.3g} rad/s"
        name, turning = AXES[self.variable]
        between = f"between {self.lower:.3g} and {self.upper:.3g}"
        return f"at a {name}{joint} {between} {unit_for(turning, prismatic)}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Map:
    """Residual energy above the noise per bin of one variable.

    Parameters
    ----------
    variable
        Key of `AXES`.
    edges
        Edges of the bins, shape (n + 1,).
    excess
        Energy above the noise in squares of the sensor's standard deviation, shape (n,).
    rows
        Number of rows in each bin, the energy expected of noise, shape (n,).
    labels
        Names of the bins where the variable is not a number.
    """

    variable: str
    edges: Array
    excess: Array
    rows: Array
    labels: tuple[str, ...] = ()


def maps(runs: Sequence[Run], simulated: Sequence[Array]) -> tuple[Map, ...]:
    """Sort the energy of measured minus simulated readings by every variable.

    Parameters
    ----------
    runs
        Runs of one joint.
    simulated
        Simulated readings [rad], shape (n_t,) for every run.

    Returns
    -------
    tuple of Map
        One map for every variable of `AXES`, in squares of the sensor's standard deviation.
    """
    kept = [run.scored for run in runs]
    left = [((run.y[:, 0] - y) / run.sensor_std[0])[k] for run, y, k in zip(runs, simulated, kept, strict=True)]
    energy = np.concatenate([r**2 for r in left])
    # Speed comes from the simulation, where no sensor noise is differentiated.
    speed = [np.gradient(y, run.t) for run, y in zip(runs, simulated, strict=True)]

    def along(name: str, values: Sequence[Array], edges: Array | None = None, labels: tuple[str, ...] = ()) -> Map:
        all_rows = np.concatenate([v[k] for v, k in zip(values, kept, strict=True)])
        return _map(name, all_rows, energy, np.ones_like(energy), _even(all_rows) if edges is None else edges, labels)

    cycles = [find_cycles(run) for run in runs]
    turns = _count_edges(max(c.count for c in cycles))
    numbers = [np.full(run.t.size, float(k)) for k, run in enumerate(runs)]
    signs = [np.where(v < 0.0, -1.0, 1.0) for v in speed]
    return (
        along("position_rad", simulated),
        along("velocity_rad_s", speed),
        along("torque_Nm", [run.u[:, 0] for run in runs]),
        along("time_s", [run.t for run in runs]),
        along("cycle", [c.index.astype(float) for c in cycles], turns),
        along("direction", signs, np.array([-2.0, 0.0, 2.0]), ("falls", "grows")),
        along("run", numbers, np.arange(-0.5, len(runs)), tuple(run.file for run in runs)),
        _spectrum(runs, left),
    )  # fmt: skip


def _even(values: Array) -> Array:
    return np.linspace(values.min(), max(values.max(), values.min() + 1e-12), THRESHOLDS.detect.bins_per_variable + 1)


def _count_edges(count: int) -> Array:
    """Return edges of bins about the numbers 0 to count − 1, as few per bin as `bins_per_variable` allows."""
    each = -(-count // THRESHOLDS.detect.bins_per_variable)
    return np.minimum(np.arange(-(-count // each) + 1) * each, count) - 0.5


def _map(name: str, values: Array, energy: Array, expected: Array, edges: Array, labels: tuple[str, ...] = ()) -> Map:
    n = edges.size - 1
    index = np.clip(np.digitize(values, edges) - 1, 0, n - 1)
    rows = np.asarray(np.bincount(index, weights=expected, minlength=n), dtype=float)
    found = np.asarray(np.bincount(index, weights=energy - expected, minlength=n), dtype=float)
    return Map(variable=name, edges=edges, excess=found, rows=rows, labels=labels)


def _spectrum(runs: Sequence[Run], left: Sequence[Array]) -> Map:
    """Return the energy over frequency: |Σ r·e^(−jωt)|²·2/n, of mean 2 under white noise, rows taken as equidistant."""
    omega: list[Array] = []
    energy: list[Array] = []
    expected: list[Array] = []
    for run, r in zip(runs, left, strict=True):
        spacing = float(np.ptp(run.t[run.scored])) / max(r.size - 1, 1)
        frequency = np.asarray(2 * np.pi * np.fft.rfftfreq(r.size, spacing), dtype=float)
        # A real signal has every frequency twice but 0 and, for an even number of rows, the highest one.
        both = np.where((frequency == 0.0) | ((r.size % 2 == 0) & (frequency == frequency[-1])), 1.0, 2.0)
        omega.append(frequency)
        energy.append(both * np.abs(np.fft.rfft(r)) ** 2 / r.size)
        expected.append(both)
    low, high = min(float(w[1]) for w in omega), max(float(w[-1]) for w in omega)
    edges = np.geomspace(low, max(high, low * (1.0 + 1e-9)), THRESHOLDS.detect.bins_per_variable + 1)
    w, squares, mean = (np.concatenate(each) for each in (omega, energy, expected))
    return _map("frequency_rad_s", w, squares, mean, edges)


def excess(found: Sequence[Map]) -> float:
    """Return the whole residual energy above the noise, in squares of the sensor's standard deviation.

    Parameters
    ----------
    found
        Residual energy per bin, one map for each variable; the first one is summed.

    Returns
    -------
    float
        Sum over its bins; negative where the residual is smaller than the noise.
    """
    return float(found[0].excess.sum())


def regions(found: Sequence[Map]) -> tuple[Region, ...]:
    """Return the narrowest range of every variable that holds the share of the excess energy that a region must hold.

    Parameters
    ----------
    found
        Maps of one joint.

    Returns
    -------
    tuple of Region
        Regions, those with the largest share of energy over their share of rows first. Frequencies come last: what
        moves a joint is always a small part of the spectrum.
    """
    regions = [r for m in found if (r := _narrowest(m)) is not None]
    return tuple(sorted(regions, key=lambda r: (r.variable == "frequency_rad_s", r.share_of_rows - r.share_of_gap)))


def describe_regions(found: Sequence[Region], prismatic: Sequence[bool], joint: str = "") -> list[str]:
    """Return sentences on the two most informative regions and on the frequencies.

    Parameters
    ----------
    found
        Regions as `regions` sorts them.
    prismatic
        Whether each free joint is prismatic, which decides the units.
    joint
        Words that follow the name of a quantity measured at the joint.

    Returns
    -------
    list of str
        One sentence for each of these regions.
    """
    first = [r for r in found if r.variable != "frequency_rad_s"][:2]
    return [r.sentence(prismatic, joint) for r in (*first, *(r for r in found if r.variable == "frequency_rad_s"))]


def _narrowest(m: Map) -> Region | None:
    total, n = float(np.maximum(m.excess, 0.0).sum()), m.excess.size
    if total <= 0.0 or n == 1:
        return None
    # Bins below the noise count 0: a negative excess would let a wide range hold more than the whole energy.
    share = np.concatenate(([0.0], np.cumsum(np.maximum(m.excess, 0.0)))) / total
    rows = np.concatenate(([0.0], np.cumsum(m.rows))) / max(float(m.rows.sum()), 1.0)
    least = THRESHOLDS.detect.least_share_of_excess_in_region
    pairs = [(b - a, a, b) for a in range(n) for b in range(a + 1, n + 1) if share[b] - share[a] >= least]
    _, a, b = min(pairs, key=lambda p: (rows[p[2]] - rows[p[1]], p))
    lower, upper = _ends(m, a, b)
    return Region(
        variable=m.variable, lower=lower, upper=upper, share_of_gap=float(share[b] - share[a]),
        share_of_rows=float(rows[b] - rows[a]), files=m.labels[a:b] if m.variable == "run" else (),
    )  # fmt: skip


def _ends(m: Map, a: int, b: int) -> tuple[float, float]:
    """Return the ends of bins a to b: edges of a continuous variable, first and last value of a counted one."""
    if m.variable == "direction":
        return (-1.0, 1.0)[a], (-1.0, 1.0)[b - 1]
    inside = 0.5 if m.variable in ("cycle", "run") else 0.0
    return float(m.edges[a] + inside), float(m.edges[b] - inside)
