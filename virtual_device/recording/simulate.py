"""Measured positions of one joint: integration, disturbances and sensor together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from haptid.support.errors import InputError
from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.machine.effects import Scales, resolve
from haptid.virtual_device.machine.friction import OF_LAWS
from haptid.virtual_device.machine.joint import BASE, JOINT, integrate
from haptid.virtual_device.recording.sensor import Sensor, cycle_factors

EXACT = Sensor(noise=0.0, resolution=0.0)


def complete(parameters: Mapping[str, float]) -> dict[str, float]:
    """Return all parameters of the undisturbed joint, its friction law among them; those not given are neutral.

    Parameters
    ----------
    parameters
        Some of the base parameters by name, SI units; ``q0`` and ``v0`` are let through, and left out.

    Returns
    -------
    dict of str to float
        All of `joint.BASE` and `friction.OF_LAWS` by name.

    Raises
    ------
    InputError
        Where a name is another.
    """
    names = (*BASE, *OF_LAWS)
    unknown = sorted(set(parameters) - set(names) - {"q0", "v0"})
    if unknown:
        raise InputError(where="parameters", expected=f"some of {', '.join(names)}, q0, v0", got=", ".join(unknown))
    return {name: float(parameters.get(name, JOINT.neutral()[name])) for name in names}


def _rest(joint: Mapping[str, float]) -> float:
    """Return the rest position; a joint without a spring rests where it is told to be."""
    return JOINT.rest_position(joint) if joint["Ks"] > 0 else joint["epos"]


def scales_of(parameters: Mapping[str, float], torque: float, frequency: float) -> Scales:
    """Estimate the scales of a joint under a cosine torque.

    Parameters
    ----------
    parameters
        Some of the base parameters by name, SI units.
    torque
        Amplitude [N m].
    frequency
        Frequency [rad/s].

    Returns
    -------
    Scales
        Torque, amplitude, speed and rest position.

    Raises
    ------
    InputError
        Where a parameter is unknown.
    NumericalError
        Where the joint has no stable rest.
    """
    joint = complete(parameters)
    return Scales.of(joint, torque, frequency, JOINT.rest_position(joint))


def simulate_joint(  # noqa: PLR0913 - what a user of a test bench sets, by keyword
    parameters: Mapping[str, float],
    t: Array,
    torque: Array,
    *,
    effects: Mapping[str, float | Mapping[str, float]] | None = None,
    hold: str = "zero",
    sensor: Sensor = EXACT,
    period: float | None = None,
    seed: int | np.random.SeedSequence = 0,
) -> Array:
    """Simulate and read the position of one joint.

    Parameters
    ----------
    parameters
        Some of the base parameters by name (see `joint.BASE`, `friction.OF_LAWS`); ``q0`` [rad] and ``v0`` [rad/s]
        set the start, which otherwise is at rest where spring and gravity balance.
    t, torque
        Rows of the table [s], [N m], shape (n,).
    effects
        Disturbances by name: a size (1 is marked, 0 is none) or a mapping of ``joint.c``'s parameters.
        ``amplitude_scatter`` takes ``scatter`` and ``scatter_on_torque`` (0: on the measured amplitude).
    hold
        ``zero`` or ``linear``.
    sensor
        Noise and steps; exact by default.
    period
        Length of a drive cycle [s]: needed with amplitude scatter, and to give a size its scale (default 2π/1.5).
    seed
        Of noise and scatter.

    Returns
    -------
    ndarray, shape (n,)
        Readings [rad].

    Raises
    ------
    InputError
        Where a parameter or a disturbance is unknown, or amplitude scatter has no ``period``.
    NumericalError
        Where the joint has no stable rest, or its motion stops being finite.
    """
    joint = complete(parameters)
    frequency = 2 * np.pi / period if period else 1.5
    strongest = float(np.max(np.abs(torque))) or 1.0
    values = resolve(effects or {}, Scales.of(joint, strongest, frequency, _rest(joint)))
    scatter, on_torque = values.pop("scatter", 0.0), bool(values.pop("scatter_on_torque", 0.0))
    rest = _rest(joint | values)
    sequence = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
    noise_seed, scatter_seed = sequence.spawn(2)
    factors = np.ones_like(t)
    if scatter != 0.0:
        if period is None:
            raise InputError(where="amplitude_scatter", expected="the period of the drive", got="None")
        factors = cycle_factors(t, period, scatter, np.random.default_rng(scatter_seed))
    driven = torque * factors if on_torque else torque
    start = float(parameters.get("q0", rest)), float(parameters.get("v0", 0.0))
    position = integrate(joint | values, t, driven, hold=hold, start=start)[2]
    if not on_torque:
        position = rest + (position - rest) * factors
    return sensor.read(t, position, np.random.default_rng(noise_seed))
