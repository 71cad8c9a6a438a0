"""Torque amplitudes and frequencies as design variables: choose the cosine runs that identify a locked joint best.

`Device` and joint come in, an `ExcitationPlan` goes out. The Fisher information of a run is F = Σ_t (∂y/∂θ)ᵀ(∂y/∂θ)/σ²
from the kernel's exact sensitivities at the first guesses, with θ in units of its first guess. The expected covariance
of a set of runs is (F₀ + Σ F)⁻¹ with the weak prior F₀ = 1, a standard deviation of 100 %.

1. Find the largest torque that keeps the joint within its limits.
2. Simulate every run of a grid of amplitudes and frequencies with its sensitivities.
3. Choose runs D-optimally, one at a time: the largest log det(F₀ + Σ F).
4. Exchange one run at a time for the best one given the others, in two sweeps (Fedorov 1972).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haptid.model.device.device import Device
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.registry import law_named
from haptid.model.joint.checked_coefficients import checked_coefficients
from haptid.model.joint.joint_in_device import joint_quantities
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.parameter_table import joint_parameters
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.rigid_body.locked_dynamics import locked_motion
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import NumericalError
from haptid.support.linear_algebra import inverse

Array = NDArray[np.float64]
DURATION_S, ROWS_PER_S = 16.0, 200.0
"""Length of a run [s] and its sampling rate [1/s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CosineRun:
    """One run with τ = amplitude·cos(ω t), in N and m for a prismatic joint.

    Parameters
    ----------
    amplitude
        Torque amplitude [N m].
    omega
        Angular frequency ω [rad/s].
    information
        Fisher information of the n free parameters in units of their first guesses, shape (n, n).
    travel
        Peak-to-peak motion [rad].
    presliding
        Share of samples within one presliding length of the last reversal.
    """

    amplitude: float
    omega: float
    information: Array
    travel: float
    presliding: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ExcitationPlan:
    """Chosen runs of one joint in comparison with a plain set of runs.

    Parameters
    ----------
    joint
        Number of the joint.
    parameters
        The n free parameters.
    plain
        As many runs as chosen, of the middle amplitude at evenly spaced frequencies.
    chosen
        D-optimal runs.
    std_plain, std_chosen
        Expected standard errors of either set, in the parameters' units, shape (n,).
    warnings
        Sentences on parameters that the chosen runs leave open.
    """

    joint: int
    parameters: tuple[Quantity, ...]
    plain: tuple[CosineRun, ...]
    chosen: tuple[CosineRun, ...]
    std_plain: Array
    std_chosen: Array
    warnings: tuple[str, ...]


def locked_quantities(device: Device, joint: int) -> tuple[Quantity, ...]:
    """Return the parameters of a locked joint with the device's first guesses.

    Parameters
    ----------
    device
        Device with the joint.
    joint
        Number of the free joint; the others are locked at home.

    Returns
    -------
    tuple of Quantity
        Inertia and gravity as implied by the links, then drive, spring and friction.

    Raises
    ------
    InputError
        Where the links imply an impossible inertia or gravity (`checked_coefficients`).
    """
    coefficients = checked_coefficients(device, locked_motion(device, (joint,)))
    rigid = {c.id: c.initial for c in coefficients}
    slides, friction = device.joints[joint].prismatic, device.joints[joint].friction
    rows = [row for row in joint_parameters(prismatic=slides, friction=friction) if row.id in rigid]
    inertial = [
        row.but(initial=rigid[row.id], lower=min(row.lower, rigid[row.id]), upper=max(row.upper, rigid[row.id]))
        for row in rows
    ]
    return (*inertial, *joint_quantities(device, joint))


def plan_excitation(device: Device, joint: int, *, runs: int = 5, noise: float = 2e-4) -> ExcitationPlan:
    """Choose D-optimal cosine runs for a locked joint.

    Parameters
    ----------
    device
        Device with first guesses.
    joint
        Number of the free joint; the others are locked at home.
    runs
        Number of runs to choose.
    noise
        Standard deviation of the white noise of the position [rad] or [m].

    Returns
    -------
    ExcitationPlan
        Chosen runs, the plain set and the expected standard errors of both.

    Raises
    ------
    InputError
        Where the links imply an impossible inertia or gravity.
    NumericalError
        Where no torque keeps the joint within its limits.
    """
    quantities = locked_quantities(device, joint)
    slides, friction = device.joints[joint].prismatic, device.joints[joint].friction
    kernel = cached_kernel(joint_equations(0, parameters=quantities, prismatic=slides, friction=friction))
    free = [i for i, one in enumerate(quantities) if not one.fixed]
    units = np.array([_unit(one) for one in quantities])[free]
    largest = _largest_torque(device, joint, kernel, quantities)
    frequencies = _frequencies(device, joint, quantities)
    pool = [
        _make_run(kernel, quantities, free, units, share * largest, omega, noise)
        for share in THRESHOLDS.torque_amplitudes_over_largest
        for omega in frequencies
    ]
    plain_index = [
        len(frequencies) * (len(THRESHOLDS.torque_amplitudes_over_largest) // 2) + int(i)
        for i in np.linspace(0, len(frequencies) - 1, runs).round()
    ]
    chosen = tuple(pool[i] for i in sorted(_d_optimal([run.information for run in pool], runs)))
    plain = tuple(pool[i] for i in plain_index)
    return ExcitationPlan(
        joint=joint,
        parameters=tuple(quantities[i] for i in free),
        plain=plain,
        chosen=chosen,
        std_plain=units * _expected_errors(plain),
        std_chosen=units * _expected_errors(chosen),
        warnings=_warnings(chosen),
    )


def _unit(quantity: Quantity) -> float:
    """Return the unit of θ: the first guess, or where it is 0, 0.1 for a position and 1e-3 for any other parameter."""
    fallback = 0.1 if quantity.unit in ("rad", "m") else 1e-3
    return abs(quantity.initial) or fallback


def _values(quantities: Sequence[Quantity]) -> dict[str, float]:
    return {one.id: one.initial for one in quantities}


def _frequencies(device: Device, joint: int, quantities: Sequence[Quantity]) -> Array:
    """Return eight frequencies [rad/s] from 0.5 to the amplifier's limit, or to twice the joint's natural frequency."""
    value = _values(quantities)
    natural = np.sqrt(max(value.get("Ks", 0.0), 0.0) / value["inertia"])
    highest = min(device.joints[joint].max_frequency, max(2 * natural, 3.0))
    return np.linspace(min(0.5, highest / 4), highest, 8)


def _largest_torque(device: Device, joint: int, kernel: CompiledKernel, quantities: Sequence[Quantity]) -> float:
    """Return the largest amplitude that keeps the joint within 80 % of its limits at every planned frequency."""
    lower, upper = device.joints[joint].planned_range
    room = 0.8 * min(abs(lower), abs(upper))
    value = _values(quantities)
    # the search goes down from four times the larger of two torques: the spring's at the limit, and twice the stiction
    start = max(value.get("Ks", 0.0) * room, 2 * value[law_named(device.joints[joint].friction).roles.stiction])
    torque = min(device.joints[joint].torque_limit, 4 * start)
    frequencies = _frequencies(device, joint, quantities)
    for _ in range(12):
        reach = max(np.abs(_simulate(kernel, quantities, torque, omega)[1]).max() for omega in frequencies)
        if np.isfinite(reach) and reach <= room:
            return torque
        torque *= 0.7
    msg = f"joint {joint}: no torque keeps it within {room:.3g} rad: the first guesses make it unstable or it drifts"
    raise NumericalError(msg)


def _simulate(
    kernel: CompiledKernel, quantities: Sequence[Quantity], amplitude: float, omega: float
) -> tuple[Array, Array]:
    t = np.arange(0.0, DURATION_S, 1.0 / ROWS_PER_S)
    u = amplitude * np.cos(omega * t)[:, np.newaxis]
    y = kernel.simulate(t, u, [one.initial for one in quantities], np.zeros(len(kernel.equations.states)))
    return t, y[:, 0]


def _make_run(
    kernel: CompiledKernel,
    quantities: Sequence[Quantity],
    free: list[int],
    units: Array,
    amplitude: float,
    omega: float,
    noise: float,
) -> CosineRun:
    t = np.arange(0.0, DURATION_S, 1.0 / ROWS_PER_S)
    u = amplitude * np.cos(omega * t)[:, np.newaxis]
    y, dy = kernel.simulate_tangent(t, u, [one.initial for one in quantities], np.zeros(len(kernel.equations.states)))
    scaled = dy[:, 0, free] * units / noise
    value = _values(quantities)
    bristle = law_named(kernel.equations.friction[0]).presliding_length(value)
    return CosineRun(
        amplitude=float(amplitude),
        omega=float(omega),
        information=scaled.T @ scaled,
        travel=float(np.ptp(y)),
        presliding=_presliding_share(y[:, 0], bristle),
    )


def _presliding_share(y: Array, length: float) -> float:
    """Return the share of samples that lie within `length` of the last reversal."""
    speed = np.sign(np.diff(y))
    reversal, inside = y[0], 0
    for before, now, position in zip(speed[:-1], speed[1:], y[1:-1], strict=True):
        if now * before < 0:
            reversal = position
        inside += abs(position - reversal) < length
    return float(inside / max(len(y) - 2, 1))


def _d_optimal(information: Sequence[Array], runs: int) -> list[int]:
    prior = np.eye(len(information[0]))
    chosen: list[int] = []

    # a run stays in the pool after its choice: the same run twice is a valid design
    def worth(others: Array) -> int:
        return int(np.argmax([np.linalg.slogdet(others + one)[1] for one in information]))

    for _ in range(runs):
        chosen.append(worth(prior + sum(information[i] for i in chosen)))
    for place in [*range(runs)] * 2:
        chosen[place] = worth(prior + sum(information[i] for n, i in enumerate(chosen) if n != place))
    return chosen


def _expected_errors(runs: Sequence[CosineRun]) -> Array:
    """Return expected standard errors in units of θ, with a prior standard deviation of one unit, shape (n,)."""
    total = np.eye(len(runs[0].information)) + sum(run.information for run in runs)
    return np.asarray(np.sqrt(np.diag(inverse(total))))


def _warnings(runs: Sequence[CosineRun]) -> tuple[str, ...]:
    if all(run.presliding > 0.98 for run in runs):
        return (
            "The runs never leave presliding: Coulomb friction, viscous friction and the Stribeck speed stay open.",
        )
    if all(run.presliding * DURATION_S * ROWS_PER_S < 20 for run in runs):
        return ("The runs hardly enter presliding: bristle stiffness and damping stay open; add a small, slow run.",)
    return ()
