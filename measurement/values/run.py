"""A measured run: the frozen value that everything downstream fits, samples and judges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Use = Literal["fit", "validate", "excluded"]
Hold = Literal["zero", "linear"]


def frozen(values: ArrayLike) -> Array:
    """Return a read-only float64 copy."""
    array = np.array(values, dtype=np.float64, order="C")
    array.flags.writeable = False
    return array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Run:
    """One run of a campaign.

    Parameters
    ----------
    file
        Name of the table within the campaign.
    free_joints
        The joints that move, ascending.
    t
        Time since the first row [s], shape (n_t,), strictly increasing, t[0] = 0.
    u
        Commanded torques [N m] (forces [N]), shape (n_t, n_joints).
    y
        Measured positions [rad] ([m]), shape (n_t, n_joints).
    v
        Measured velocities [rad/s], shape (n_t, n_joints), or None.
    noise
        Standard deviation of the white sensor noise [rad], shape (n_joints,); NaN where it is to be estimated.
    resolution
        Encoder step [rad], shape (n_joints,); 0 where there is none, NaN where it is to be estimated.
    posture
        Position of every joint of the device [rad], shape (n_q,); entries of free joints are ignored.
        Empty for ``single_joint``.
    use
        ``fit``, ``validate`` or ``excluded``.
    hold
        How torque runs between rows.
    start_time
        Time of the first row in the table [s].
    reason
        Why the run is excluded.
    notes
        Sentences that a report shows with the run.
    prismatic
        Whether each free joint slides (u in N, y in m, v in m/s), shape (n_joints,); all turn by default.
    extra
        Further columns of the table, each of shape (n_t,), NaN where a cell holds no number. Nothing fits them.
    score_from
        First row whose residual is scored; the rows before it only bring the simulation to that point.
    """

    file: str
    free_joints: tuple[int, ...]
    t: Array
    u: Array
    y: Array
    v: Array | None = None
    noise: Array
    resolution: Array
    posture: Array
    use: Use
    hold: Hold = "zero"
    start_time: float = 0.0
    reason: str = ""
    notes: tuple[str, ...] = field(default=())
    prismatic: tuple[bool, ...] = ()
    extra: Mapping[str, Array] = field(default_factory=dict)
    score_from: int = 0

    def __post_init__(self) -> None:
        """Check shapes and make the arrays read-only."""
        object.__setattr__(self, "prismatic", tuple(self.prismatic) or (False,) * len(self.free_joints))
        object.__setattr__(self, "extra", {name: frozen(column) for name, column in self.extra.items()})
        for name in ("t", "u", "y", "noise", "resolution", "posture"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        if self.v is not None:
            object.__setattr__(self, "v", frozen(self.v))
        shape = (self.t.size, len(self.free_joints))
        for name in ("u", "y", "v"):
            value = getattr(self, name)
            if value is not None and value.shape != shape:
                msg = f"{self.file}: {name} needs shape {shape}, got {value.shape}"
                raise ValueError(msg)
        if len(self.prismatic) != len(self.free_joints) or not 0 <= self.score_from < max(self.t.size, 1):
            msg = f"{self.file}: prismatic {self.prismatic} or score_from {self.score_from} does not fit the run"
            raise ValueError(msg)

    @property
    def sensor_std(self) -> Array:
        """√(noise² + resolution²/12), shape (n_joints,)."""
        return np.sqrt(self.noise**2 + self.resolution**2 / 12.0)

    @property
    def scored(self) -> slice:
        """Rows whose residual is scored."""
        return slice(self.score_from, None)

    def but(self, **changes: Any) -> Run:
        """Return a copy with ``changes``."""
        return replace(self, **changes)
