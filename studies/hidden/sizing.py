"""How large a disturbance must be: as a share of the motion, or by what a refit of the joint leaves of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from haptid.support.errors import NumericalError
from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.machine.effects import FORMULAS, Scales, Shape, Values
from haptid.virtual_device.machine.joint import BASE, JOINT, integrate
from haptid.virtual_device.recording.inputs import Cosine

COARSE = 1e-4
"""Integration step of these estimates [s]."""
SIGNED = ("epos", "gravity_cos", "gravity_sin")
"""Parameters that may be of either sign."""
LARGEST = 4.0
SMALLEST = 1e-4
REFITS, ARRIVED, SLOW, NOTHING = 20, 1.05, 0.5, 1e-4
"""Most steps of a refit, how near to what the slopes promise it has to come, what share of the rest a step leaves where
the next one takes the slopes anew, and the share of the change that is as good as nothing."""
SHARES = (1.0, 0.3, 0.1)
"""Shares of a step that are tried, the whole one first."""
FARTHEST = 5.0
"""Largest factor by which a refit may change a positive parameter: beyond, it is another joint, and a stiff one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """What the joint does undisturbed, and what its own parameters can change.

    Parameters
    ----------
    parameters
        The joint.
    runs
        Tests on which the disturbance is judged.
    motion
        Undisturbed positions, all runs one after another, shape (n,).
    free
        Names of the parameters that a fit may change.
    slopes
        ∂position/∂(free parameters, start of each run), shape (n, m).
    max_step
        Longest integration step [s].
    """

    parameters: Mapping[str, float]
    runs: Sequence[Cosine]
    motion: Array
    free: tuple[str, ...]
    slopes: Array
    max_step: float = COARSE

    def effect(self, values: Mapping[str, float]) -> Array:
        """Return how a disturbance changes the positions.

        Parameters
        ----------
        values
            Parameters of the disturbance by name, SI units.

        Returns
        -------
        ndarray, shape (n,)
            Disturbed minus undisturbed positions [rad].

        Raises
        ------
        NumericalError
            Where the disturbed joint runs away.
        """
        return np.asarray(positions({**self.parameters, **values}, self.runs, max_step=self.max_step) - self.motion)

    def share(self, change: Array) -> float:
        """Return a change relative to the motion.

        Parameters
        ----------
        change
            Change of the positions [rad], shape (n,).

        Returns
        -------
        float
            RMS of the change over the RMS of the motion about its mean [1].
        """
        return float(_rms(change) / np.std(self.motion))

    def left(self, change: Array) -> float:
        """Return what a refit leaves of a change, by Gauss-Newton steps with the slopes taken anew where they mislead.

        To first order alone a refit that has to go far (weight and stiffness that take up a bent spring) seems to leave
        more than it does. Where no step leads on, it is what the slopes promise.

        Parameters
        ----------
        change
            Change of the positions [rad], shape (n,).

        Returns
        -------
        float
            RMS [rad].
        """
        moved, slopes, fresh, rest = np.zeros(self.slopes.shape[1]), self.slopes, True, _rms(change)
        left = change
        for _ in range(REFITS):
            step, rest = _refit_step(slopes, left)
            if _rms(left) < max(ARRIVED * rest, NOTHING * _rms(change)):
                break
            found = self._further(change, moved, step, _rms(left))
            if found is None and fresh:
                break
            fresh = found is None or _rms(found[1]) > SLOW * _rms(left)
            moved, left = found or (moved, left)
            if fresh:
                slopes = reach(self._moved(moved), self.runs, self.fixed, self.max_step).slopes
        return rest

    def left_at_first(self, change: Array) -> float:
        """Return what a refit leaves of a change to first order: right for a small change, most for others.

        Parameters
        ----------
        change
            Change of the positions [rad], shape (n,).

        Returns
        -------
        float
            RMS [rad].
        """
        return _refit_step(self.slopes, change)[1]

    def _further(self, change: Array, moved: Array, step: Array, before: float) -> tuple[Array, Array] | None:
        """Return where the first share of a step that leaves less than before leads, and what it leaves; else None."""
        for share in SHARES:
            try:
                left = self.motion + change - self.at(moved + share * step)
            except NumericalError:
                continue
            if _rms(left) < before:
                return moved + share * step, left
        return None

    @property
    def fixed(self) -> tuple[str, ...]:
        """Names of the parameters that a fit may not change."""
        return tuple(name for name in BASE if name not in self.free)

    def at(self, moved: Array) -> Array:
        """Simulate the runs with the free parameters and the starts moved.

        Parameters
        ----------
        moved
            Changes of the free parameters in SI units, then of the starts, shape (n_free + n_starts,).

        Returns
        -------
        ndarray, shape (n,)
            Positions of all runs one after the other [rad]; the starts act by their slopes.

        Raises
        ------
        NumericalError
            Where it runs away, or a positive parameter goes beyond `FARTHEST`.
        """
        motion = positions(self._moved(moved), self.runs, max_step=self.max_step)
        return motion + self.slopes[:, len(self.free) :] @ moved[len(self.free) :]

    def _moved(self, moved: Array) -> dict[str, float]:
        parameters = dict(self.parameters)
        for name, change in zip(self.free, moved, strict=False):
            parameters[name] = parameters[name] + float(change)
            if name not in SIGNED and not 1 / FARTHEST < parameters[name] / self.parameters[name] < FARTHEST:
                msg = f"{name} would have to go from {self.parameters[name]:g} to {parameters[name]:g}"
                raise NumericalError(msg)
        return parameters


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _refit_step(slopes: Array, left: Array) -> tuple[Array, float]:
    """Return the step that takes up most of ``left`` to first order, and the RMS of the rest [rad]."""
    scale = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
    step = np.linalg.lstsq(slopes / scale, left, rcond=1e-8)[0] / scale
    return step, _rms(left - slopes @ step)


def positions(
    parameters: Mapping[str, float], runs: Sequence[Cosine], shift: float = 0.0, max_step: float = COARSE
) -> Array:
    """Simulate all runs without noise.

    Parameters
    ----------
    parameters
        Parameters of the joint, disturbed or not, by name, SI units.
    runs
        Runs.
    shift
        Start relative to the rest position [rad].
    max_step
        Longest integration step [s].

    Returns
    -------
    ndarray, shape (n,)
        Every fourth noise-free encoder reading [rad], one run after another.

    Raises
    ------
    NumericalError
        Where the joint has no stable rest, or runs away.
    """
    start = JOINT.rest_position(parameters) + shift
    made = [integrate(parameters, run.times(), run.torque(), start=(start, 0.0), max_step=max_step)[2] for run in runs]
    return np.concatenate([readings[::4] for readings in made])


def reach(
    parameters: Mapping[str, float],
    runs: Sequence[Cosine],
    fixed: Sequence[str] = ("Kp",),
    max_step: float = COARSE,
) -> Reach:
    """Differentiate the motion with respect to the parameters that a fit may change, and to the start of each run.

    Parameters
    ----------
    parameters
        Parameters of the undisturbed joint by name, SI units.
    runs
        Tests on which disturbances are judged.
    fixed
        Names of the parameters that a fit may not change.
    max_step
        Longest integration step [s].

    Returns
    -------
    Reach

    Raises
    ------
    NumericalError
        Where the joint has no stable rest, or runs away.
    """
    move = partial(positions, runs=runs, max_step=max_step)
    motion, columns = move(parameters), []
    free = tuple(name for name in BASE if name not in fixed)
    for name in free:
        step = 1e-3 * abs(parameters[name]) if name not in SIGNED else 1e-4
        step *= 0.1 * parameters["Ks"] if name.startswith("gravity") else 1.0
        columns.append((move({**parameters, name: parameters[name] + step}) - motion) / step)
    shifted, first = (move(parameters, shift=1e-4) - motion) / 1e-4, 0
    for run in runs:
        last = first + len(run.times()[::4])
        columns.append(np.where((np.arange(motion.size) >= first) & (np.arange(motion.size) < last), shifted, 0.0))
        first = last
    slopes = np.stack(columns, axis=1)
    return Reach(parameters=parameters, runs=runs, motion=motion, free=free, slopes=slopes, max_step=max_step)


def threshold_size(base: Reach, effect: Callable[[float], Values], target: float) -> float:
    """Return the size at which a refit leaves a stated rest of the disturbance.

    Parameters
    ----------
    base
        Undisturbed joint.
    effect
        Parameters of the disturbance as a function of its size.
    target
        RMS that a refit should leave [rad].

    Returns
    -------
    float
        Size [1] between `SMALLEST` and `LARGEST`.
    """
    return solve_size(lambda k: base.left(base.effect(effect(k))), target)


def share_size(base: Reach, effect: Callable[[float], Values], share: float) -> float:
    """Return the size at which the disturbance is a stated share of the motion.

    Parameters
    ----------
    base
        Undisturbed joint.
    effect
        Parameters of the disturbance as a function of its size.
    share
        RMS of the disturbance over that of the motion [1].

    Returns
    -------
    float
        Size [1] between `SMALLEST` and `LARGEST`.
    """
    return solve_size(lambda k: base.share(base.effect(effect(k))), share)


def marked_size(base: Reach, effect: Callable[[float], Values], share: float, floor: float) -> float:
    """Return the size at which the disturbance is a share of the motion, larger where a refit would leave too little.

    Parameters
    ----------
    base
        Undisturbed joint.
    effect
        Parameters of the disturbance as a function of its size.
    share
        RMS of the disturbance over that of the motion [1].
    floor
        Least RMS that a refit should leave [rad].

    Returns
    -------
    float
        Size [1] between `SMALLEST` and `LARGEST`.
    """
    size = share_size(base, effect, share)
    if base.left(base.effect(effect(size))) < floor:
        size = max(size, threshold_size(base, effect, floor))
    return size


def solve_size(measure: Callable[[float], float], target: float) -> float:
    """Find k with measure(k) = target, for a measure about proportional to k.

    Parameters
    ----------
    measure
        Function of the size.
    target
        Value that it should have, in the unit of ``measure``.

    Returns
    -------
    float
        Size [1] between `SMALLEST` and `LARGEST`.
    """
    size, low, high = 0.5, SMALLEST, LARGEST
    for _ in range(7):
        ratio = target / max(_finite(measure, size), 1e-15)
        if abs(np.log(max(ratio, 1e-300))) < 0.1 or (size == LARGEST and ratio > 1):
            break
        low, high = (size, high) if ratio > 1 else (low, size)
        aimed = size * float(np.clip(ratio, 1e-2, 30.0))
        size = aimed if low < aimed < high else high if high == LARGEST < aimed else float(np.sqrt(low * high))
    return size


def _finite(measure: Callable[[float], float], size: float) -> float:
    """Return the measure, infinite where the joint runs away."""
    try:
        return measure(size)
    except NumericalError:
        return float("inf")


def formula(name: str, scales: Scales, shape: Shape) -> Callable[[float], Values]:
    """Return the parameters of a disturbance as a function of its size.

    Parameters
    ----------
    name
        Name of the disturbance.
    scales
        Orders of magnitude of the joint in its tests.
    shape
        Features that the size leaves open.

    Returns
    -------
    callable
        Takes the size [1], returns parameters by name, SI units.
    """
    return lambda size: FORMULAS[name](scales, size, shape)
