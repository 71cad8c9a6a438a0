"""What the parameters of a hidden disturbance are in the catalogue's terms, so that intervals can be held against them.

The maker of the cases writes a·sin(n·q + φ), stiffnesses and inertias; the catalogue has a_s·sin(n·q) + a_c·cos(n·q),
compliances and shares. Parameters that the catalogue states as a share of a scale of the joint's runs (a cut, a gain's
curvature, a load's friction) are left out: the finding does not hold that scale.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

Hidden = Mapping[str, float]
Value = Callable[[Hidden, Mapping[str, float]], float]
SAME = {
    "k3": "spring_cubic",
    "k2": "spring_quadratic",
    "payload_cos": "payload_cos",
    "payload_sin": "payload_sin",
    "inertia_slope": "inertia_linear",
    "inertia_curvature": "inertia_quadratic",
    "coulomb_asymmetry": "coulomb_asymmetry",
    "viscous_asymmetry": "viscous_asymmetry",
    "friction_slope": "friction_slope",
    "viscous_curvature": "viscous_position",
    "friction_lag_time": "stribeck_lag",
    "stribeck_exponent_change": "stribeck_change",
    "viscous_excess": "viscous_warmup",
    "viscous_warm_up": "viscous_warmup_time",
    "coulomb_excess": "coulomb_warmup",
    "coulomb_warm_up": "coulomb_warmup_time",
    "drag": "drag",
    "hysteresis_stiffness": "hysteresis_stiffness",
    "hysteresis_travel": "hysteresis_travel",
    "slack_half_width": "tendon_slack",
    "encoder_play": "encoder_play",
    "dead_band": "dead_band",
    "lag_time": "amplifier_lag",
    "settled_lag_time": "amplifier_lag",
    "delay_time": "delay",
    "gain_drift_rate": "gain_rate",
    "bias_drift_rate": "bias_rate",
    "clock_rate": "clock_error",
    "upper_stop_stiffness": "stop_stiffness",
    "upper_stop_damping": "stop_damping",
    "upper_stop_position": "stop_upper",
    "stops_stiffness": "stop_stiffness",
    "stops_damping": "stop_damping",
    "stops_position": "stop_upper",
    "stops_lower": "stop_lower",
    "disturbance_frequency": "disturbance_frequency",
    "friction_wave_number": "friction_wave_number",
    "cogging_number": "cogging_number",
    "ripple_number": "ripple_number",
    "encoder_ripple_number": "encoder_number",
    "amplitude_scatter": "scatter",
}
"""Parameters of the catalogue that the maker states in the same way."""
WAVES = {
    "friction_wave": ("friction_wave", "friction_wave_phase"),
    "cogging": ("cogging", "cogging_phase"),
    "ripple": ("ripple", "ripple_phase"),
    "eccentricity": ("eccentricity", "eccentricity_phase"),
    "encoder_ripple": ("encoder_ripple", "encoder_phase"),
    "disturbance": ("disturbance", "disturbance_phase"),
}
"""a·sin(x + φ) = a·cos φ·sin x + a·sin φ·cos x: prefix in the catalogue, amplitude and phase of the maker."""


def _share(hidden: Hidden, _: Mapping[str, float]) -> float:
    return hidden["rotor_inertia"] / (hidden["rotor_inertia"] + hidden["inertia"])


def _compliance(hidden: Hidden, _: Mapping[str, float]) -> float:
    return 1.0 / hidden["tendon_stiffness"]


def _damping_time(hidden: Hidden, _: Mapping[str, float]) -> float:
    return hidden["tendon_damping"] / hidden["tendon_stiffness"]


def _lock_damping(hidden: Hidden, _: Mapping[str, float]) -> float:
    return hidden["lock_damping"] / (2.0 * math.sqrt(hidden["lock_stiffness"] * hidden["lock_inertia"]))


FORMULAS: dict[str, Value] = {
    "tendon_compliance": _compliance,
    "tendon_rotor_share": _share,
    "tendon_damping_time": _damping_time,
    "slack_compliance": _compliance,
    "slack_rotor_share": _share,
    "slack_damping_time": _damping_time,
    "saturation_softness": lambda hidden, _: 1.0 / hidden["saturation_soft"],
    "lock_share": lambda hidden, base: hidden["lock_coupling"] ** 2 / (hidden["lock_inertia"] * base["inertia"]),
    "lock_frequency": lambda hidden, _: math.sqrt(hidden["lock_stiffness"] / hidden["lock_inertia"]),
    "lock_damping": _lock_damping,
}


def true_value(id: str, hidden: Hidden, base: Mapping[str, float]) -> float | None:
    """Return the true value of a catalogue's parameter; None where the case does not hold it.

    Parameters
    ----------
    id
        Id of a parameter in the catalogue.
    hidden
        Parameters of the hidden disturbance by the maker's names.
    base
        Parameters of the undisturbed joint by name, SI units.

    Returns
    -------
    float or None
        Value in the catalogue's unit.

    Examples
    --------
    >>> true_value("cogging_cos", {"cogging": 2.0, "cogging_phase": math.pi / 2}, {})
    2.0
    >>> true_value("saturation_cut", {"saturation_hard": 0.01}, {}) is None
    True
    """
    if id in FORMULAS:
        try:
            return FORMULAS[id](hidden, base)
        except KeyError:
            return None
    if id in SAME:
        return hidden.get(SAME[id])
    prefix, _, part = id.rpartition("_")
    if part not in ("sin", "cos") or prefix not in WAVES:
        return None
    amplitude, phase = (hidden.get(name) for name in WAVES[prefix])
    if amplitude is None or phase is None:
        return None
    return amplitude * (math.cos(phase) if part == "sin" else math.sin(phase))
