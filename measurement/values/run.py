"""`Run`, the frozen value of one measured time series that fits, samplers and searches take.

Angles and torques of revolute joints are in rad and N m; those of prismatic joints in m and N.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Use = Literal["fit", "validate", "excluded"]
"""Use of a run: fitted, kept for validation, or ignored."""
Hold = Literal["zero", "linear"]
"""Torque between two rows: that of the row before, or interpolated."""


def freeze(values: ArrayLike) -> Array:
    """Return a read-only float64 copy of ``values``, in C order and of the same shape.

    Parameters
    ----------
    values
        Numbers in any unit and shape.

    Returns
    -------
    ndarray of float64
        A copy: later changes of ``values`` do not reach it.
    """
    array = np.array(values, dtype=np.float64, order="C")
    array.flags.writeable = False
    return array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Run:
    """Hold the time series of one run with what is known of its sensor and its posture.

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
        Torque between two rows: ``zero`` holds the row before, ``linear`` interpolates.
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
    drive_inputs
        Inputs of the equations with a drive by id, each of shape (n_t,), in the order of `drive_terms.drive_inputs`;
        ``u`` is then the torque that they make at the stated parameters of the drive. Empty where u is the input.
    score_from
        Index of the first row whose residual is scored. The rows before bring the simulation to that state.
    averaged_rows
        Number of rows over which the recorder averaged each position, evenly about it; 1 where it did not, 0 where
        nobody said so and it is to be recognised. Simulated positions are averaged alike.
    weight
        Weight of each row's residual in a fit [1], at most 1, shape (n_t,): its error has the standard deviation
        `sensor_std` over the weight, and with 0 the row takes no part. Empty where every row has the weight 1.

    Raises
    ------
    ValueError
        Where an array has another shape, or ``score_from`` lies outside the rows.

    Notes
    -----
    Two runs are equal only where they are the same object (``eq=False``): arrays have no truth value, and caches
    such as `whole_cycles` may take a run as their key.
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
    drive_inputs: Mapping[str, Array] = field(default_factory=dict)
    score_from: int = 0
    averaged_rows: int = 0
    weight: Array = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Check shapes and make the arrays read-only."""
        object.__setattr__(self, "prismatic", tuple(self.prismatic) or (False,) * len(self.free_joints))
        object.__setattr__(self, "extra", {name: freeze(column) for name, column in self.extra.items()})
        driven = {name: freeze(column) for name, column in self.drive_inputs.items()}
        object.__setattr__(self, "drive_inputs", driven)
        for name in ("t", "u", "y", "noise", "resolution", "posture", "weight"):
            object.__setattr__(self, name, freeze(getattr(self, name)))
        if self.v is not None:
            object.__setattr__(self, "v", freeze(self.v))
        shape = (self.t.size, len(self.free_joints))
        for name in ("u", "y", "v"):
            value = getattr(self, name)
            if value is not None and value.shape != shape:
                msg = f"{self.file}: {name} needs shape {shape}, got {value.shape}"
                raise ValueError(msg)
        if self.weight.size not in (0, self.t.size):
            msg = f"{self.file}: weight needs one number a row, got {self.weight.size} for {self.t.size} rows"
            raise ValueError(msg)
        if len(self.prismatic) != len(self.free_joints) or not 0 <= self.score_from < max(self.t.size, 1):
            msg = f"{self.file}: prismatic {self.prismatic} or score_from {self.score_from} does not fit the run"
            raise ValueError(msg)

    @property
    def inputs(self) -> Array:
        """Inputs of the equations: those of the drive, else the torques, shape (n_t, n_inputs)."""
        return np.column_stack(tuple(self.drive_inputs.values())) if self.drive_inputs else self.u

    @property
    def sensor_std(self) -> Array:
        """Standard deviation of a reading, √(noise² + resolution²/12) [rad] ([m]), shape (n_joints,).

        A reading that is rounded to a step h has an error of variance h²/12, uniform over the step.
        """
        return np.sqrt(self.noise**2 + self.resolution**2 / 12.0)

    @property
    def largest_torque(self) -> float:
        """Largest magnitude of the torques of joints that turn [N m]; 0 where none turns."""
        torques = self.u[:, [not slides for slides in self.prismatic]]
        return float(np.nanmax(np.abs(torques), initial=0.0))

    @property
    def row_std(self) -> Array:
        """Standard deviation of each row's error, `sensor_std` over its weight, shape (n_t, n_joints).

        Infinite where the weight is 0, so that what is divided by it vanishes.
        """
        if not self.weight.size:
            return np.broadcast_to(self.sensor_std, self.y.shape)
        with np.errstate(divide="ignore"):
            return self.sensor_std / self.weight[:, None]

    @property
    def scored(self) -> slice:
        """Slice of the rows whose residual is scored."""
        return slice(self.score_from, None)

    def but(self, **changes: Any) -> Run:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Run
            The copy, its arrays read-only.
        """
        return replace(self, **changes)
