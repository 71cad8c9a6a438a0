"""Disturbances by name: which parameters of ``joint.c`` each one sets, at a size of 1, for a joint of a given scale.

A size of 1 moves the joint by a few percent of its motion; the disturbance grows about linearly with size. The
formulas stand in ``joint.c``. ``LISTED`` follows the names that users meet; ``UNLISTED`` have no such name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

Values = dict[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scales:
    """Orders of magnitude of a joint in its tests.

    Parameters
    ----------
    torque
        Amplitude of the torque [N m].
    amplitude, speed
        Amplitude of the motion [rad] and of its speed [rad/s].
    rest
        Rest position [rad].
    Ks, inertia, sigma2
        Spring [N m/rad], inertia [kg m²] and viscous friction [N m s/rad] of the joint.
    """

    torque: float
    amplitude: float
    speed: float
    rest: float
    Ks: float
    inertia: float
    sigma2: float

    @classmethod
    def of(cls, joint: Mapping[str, float], torque: float, frequency: float, rest: float) -> Scales:
        """Estimate the scales of ``joint`` under a cosine torque: A = τ / |Ks − M ω² + j ω σ2|.

        Parameters
        ----------
        joint
            Parameters by name: ``Ks``, ``inertia``, ``sigma2`` and ``Fc`` are used, SI units.
        torque
            Amplitude of the torque τ [N m]; friction takes Fc of it, but no more than 70 %.
        frequency
            Frequency ω of the torque [rad/s].
        rest
            Rest position [rad].

        Returns
        -------
        Scales
            Torque, amplitude, speed and rest position.
        """
        dynamic = complex(joint["Ks"] - joint["inertia"] * frequency**2, frequency * joint["sigma2"])
        moved = max(torque - joint["Fc"], 0.3 * torque) / abs(dynamic)
        known = {key: joint[key] for key in ("Ks", "inertia", "sigma2")}
        return cls(torque=torque, amplitude=moved, speed=frequency * moved, rest=rest, **known)


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """Features of a disturbance that its size leaves open; each effect uses those that it has.

    Parameters
    ----------
    sign
        ±1.
    number
        Periods per radian turn, n in sin(n q + φ).
    phase
        φ [rad].
    place, width
        Where, and how wide, as a share of the amplitude.
    time
        A time constant, as a multiple of the effect's own.
    variant
        0 or 1, where an effect has two forms.
    """

    sign: float = 1.0
    number: float = 10.0
    phase: float = 0.5
    place: float = 0.3
    width: float = 0.25
    time: float = 1.0
    variant: int = 0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Shape:
        """Draw every feature at random.

        Parameters
        ----------
        rng
            Source of random numbers.

        Returns
        -------
        Shape
            Features with uniform distributions.
        """
        return cls(
            sign=float(rng.choice([-1.0, 1.0])),
            number=float(rng.integers(6, 21)),
            phase=float(rng.uniform(-np.pi, np.pi)),
            place=float(rng.uniform(-0.6, 0.6)),
            width=float(rng.uniform(0.15, 0.35)),
            time=float(rng.uniform(0.7, 1.4)),
            variant=int(rng.integers(2)),
        )


Formula = Callable[[Scales, float, Shape], Values]


def _wave_or_slope(s: Scales, k: float, d: Shape) -> Values:
    if d.variant:
        return {"friction_slope": 0.5 * k * d.sign / s.amplitude}
    return {"friction_wave": 0.4 * k, "friction_wave_number": d.number, "friction_wave_phase": d.phase}


def _tendon(s: Scales, stiffness: float) -> Values:
    rotor = 0.3 * s.inertia
    damping = 0.1 * float(np.sqrt(stiffness * rotor))
    joint = {"inertia": s.inertia - rotor, "rotor_inertia": rotor}
    return joint | {"tendon_stiffness": stiffness, "tendon_damping": damping}


def _saturation(s: Scales, k: float, d: Shape) -> Values:
    if d.variant:
        return {"saturation_hard": s.torque * max(0.3, 1.0 - 0.15 * k)}
    return {"saturation_soft": 1.6 * s.torque / float(np.sqrt(k))}


def _stop(s: Scales, k: float, d: Shape) -> Values:
    upper, lower = s.rest + (0.6 + 0.3 * d.place) * s.amplitude, s.rest - (0.6 - 0.3 * d.place) * s.amplitude
    one_sided = {"stop_upper": upper, "stop_lower": lower if d.variant else -1e9}
    return one_sided | {"stop_stiffness": 0.5 * k * s.Ks, "stop_damping": 0.3 * k * s.sigma2}


def _lock(s: Scales, k: float, d: Shape) -> Values:
    natural, inertia = 8.0 / d.time, s.inertia
    coupling = min(0.9, 0.35 * float(np.sqrt(k))) * inertia
    known = {"lock_inertia": inertia, "lock_coupling": coupling, "lock_stiffness": inertia * natural**2}
    return known | {"lock_damping": 0.1 * inertia * natural}


def _bell(name: str, strength: float, s: Scales, d: Shape) -> Values:
    place = {f"{name}_centre": s.rest + d.place * s.amplitude, f"{name}_width": d.width * s.amplitude}
    return place | ({"patch_damping": strength} if name == "patch" else {name: strength})


LISTED: dict[str, Formula] = {
    "cubic_spring": lambda s, k, d: {"spring_cubic": 0.12 * k * d.sign * s.Ks / s.amplitude**2},
    "asymmetric_spring": lambda s, k, d: {"spring_quadratic": 0.1 * k * d.sign * s.Ks / s.amplitude},
    "payload_gravity": lambda s, k, d: {
        "payload_cos": 0.5 * k * s.torque * float(np.cos(d.phase)),
        "payload_sin": 0.5 * k * s.torque * float(np.sin(d.phase)),
    },
    "configuration_inertia": lambda _, k, d: {"inertia_linear": 0.4 * k * d.sign, "inertia_quadratic": 0.6 * k},
    "asymmetric_coulomb": lambda _, k, d: {"coulomb_asymmetry": 0.3 * k * d.sign},
    "asymmetric_viscous": lambda _, k, d: {"viscous_asymmetry": 0.3 * k * d.sign},
    "position_dependent_friction": _wave_or_slope,
    "load_dependent_friction": lambda s, k, _: {"load_friction": 0.4 * k, "load_reference": s.torque},
    "position_dependent_viscous": lambda s, k, _: {"viscous_position": k * s.sigma2 / s.amplitude**2},
    "friction_lag": lambda _, k, __: {"stribeck_lag": 0.05 * k},
    "stribeck_shape": lambda _, k, d: {"stribeck_change": 4.0 * k if d.sign > 0 else 2.0 / (1.0 + 2.0 * k) - 2.0},
    "viscous_drift": lambda _, k, d: {"viscous_warmup": 0.4 * k, "viscous_warmup_time": 5.0 * d.time},
    "coulomb_drift": lambda _, k, d: {"coulomb_warmup": 0.4 * k, "coulomb_warmup_time": 5.0 * d.time},
    "quadratic_drag": lambda s, k, _: {"drag": 0.5 * k * s.sigma2 / s.speed},
    "cable_hysteresis": lambda s, k, d: {
        "hysteresis_stiffness": 0.15 * k * s.Ks,
        "hysteresis_travel": 0.3 * d.time * s.amplitude,
    },
    "tendon_elasticity": lambda s, k, _: _tendon(s, 6.0 * s.Ks / k),
    "tendon_slack": lambda s, k, _: _tendon(s, 30.0 * s.Ks / min(1.0, k)) | {"tendon_slack": 0.02 * k * s.amplitude},
    "backlash": lambda s, k, _: {"encoder_play": 0.03 * k * s.amplitude},
    "cogging": lambda s, k, d: {
        "cogging": 0.06 * k * s.torque,
        "cogging_number": d.number,
        "cogging_phase": d.phase,
    },
    "torque_ripple": lambda _, k, d: {"ripple": 0.1 * k, "ripple_number": d.number, "ripple_phase": d.phase},
    "amplifier_saturation": _saturation,
    "amplifier_nonlinear_gain": lambda s, k, d: {"gain_cubic": 0.1 * k * d.sign, "gain_reference": s.torque},
    "amplifier_dead_band": lambda s, k, _: {"dead_band": 0.15 * k * s.torque},
    "amplifier_lag": lambda _, k, __: {"amplifier_lag": 0.03 * k},
    "time_delay": lambda _, k, __: {"delay": 0.03 * k},
    "gain_drift": lambda _, k, d: {"gain_rate": 0.004 * k * d.sign},
    "torque_bias_drift": lambda s, k, d: {"bias_rate": 0.004 * k * d.sign * s.torque},
    "encoder_eccentricity": lambda _, k, d: {"eccentricity": 0.1 * k, "eccentricity_phase": d.phase},
    "encoder_ripple": lambda s, k, d: {
        "encoder_ripple": 0.015 * k * s.amplitude,
        "encoder_number": 15.0 + 2.0 * d.number,
        "encoder_phase": d.phase,
    },
    "clock_error": lambda _, k, d: {"clock_error": 0.002 * k * d.sign},
    "end_stop": _stop,
    "lock_compliance": _lock,
    "periodic_disturbance": lambda s, k, d: {
        "disturbance": 0.04 * k * s.torque,
        "disturbance_frequency": 4.3 * d.time,
        "disturbance_phase": d.phase,
    },
    "amplitude_scatter": lambda _, k, d: {"scatter": 0.02 * k, "scatter_on_torque": float(d.variant)},
}

UNLISTED: dict[str, Formula] = {
    "local_viscous_patch": lambda s, k, d: _bell("patch", 1.5 * k * s.sigma2, s, d),
    "magnetic_detent": lambda s, k, d: _bell("detent", 0.15 * k * d.sign * s.torque, s, d),
    "sticky_spot": lambda s, k, d: _bell("sticky", 1.2 * k, s, d),
    "viscoelastic_relaxation": lambda s, k, d: {"relaxation_stiffness": 0.15 * k * s.Ks, "relaxation_time": d.time},
    "thermal_gain": lambda s, k, d: {"heat_gain": 0.08 * k, "heat_reference": s.torque, "heat_time": 6.0 * d.time},
}

FORMULAS = LISTED | UNLISTED


def resolve(effects: Mapping[str, float | Mapping[str, float]], scales: Scales, shape: Shape | None = None) -> Values:
    """Turn sizes into parameters.

    Parameters
    ----------
    effects
        By name: a size, or the parameters themselves. A size of 0 leaves the joint as it is.
    scales
        Orders of magnitude of the joint, in which sizes are counted.
    shape
        Features that the sizes leave open; those of `Shape` where None.

    Returns
    -------
    dict
        Parameters of ``joint.c`` by name, SI units.

    Raises
    ------
    InputError
        Where a name is unknown, or two of them set the same parameter.
    """
    values: Values = {}
    for name, size in effects.items():
        if name not in FORMULAS:
            raise InputError("effects", expected="a known effect", got=repr(name), todo=did_you_mean(name, FORMULAS))
        own: Mapping[str, float] = {}
        if isinstance(size, Mapping):
            own = size
        elif size != 0.0:
            own = FORMULAS[name](scales, float(size), shape or Shape())
        if both := sorted(set(own) & set(values)):
            got = f"{name}, which sets {both[0]} as another one does"
            raise InputError(where="effects", expected="disturbances with parameters of their own", got=got)
        values |= own
    return values


def parse_effects(text: str | None) -> dict[str, float]:
    """Read disturbances and their sizes, as ``cogging=1,time_delay=0.5``.

    Parameters
    ----------
    text
        Value of the option ``--effects``; None for none.

    Returns
    -------
    dict of str to float
        Size by name; `resolve` checks the names.

    Raises
    ------
    InputError
        Where the text is no list of names with numbers.
    """
    try:
        return {name: float(size) for name, size in (part.split("=") for part in text.split(","))} if text else {}
    except ValueError:
        raise InputError(where="--effects", expected="id=size,id=size as in cogging=1", got=repr(text)) from None
