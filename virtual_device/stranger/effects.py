"""The stranger's disturbances by name: which parameters of ``stranger.c`` each one sets.

A size of 1 moves the joint by a few percent of its motion; a disturbance grows about linearly with its size. The
formulas stand in ``stranger.c``; what a size leaves open is drawn from ``ranges.toml``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from haptid.virtual_device.machine.effects import Scales, Values

Shape = Mapping[str, Any]
Formula = Callable[[Scales, float, Shape], Values]
RUN_S = 16.0
"""Length of a run [s], in which drifts are counted."""


def _wave(name: str, s: Scales, d: Shape) -> Values:
    return {f"{name}_number": d["number"] / s.amplitude, f"{name}_phase": d["phase"]}


def _stop(s: Scales, k: float, d: Shape) -> Values:
    ends = {"upper": s.rest + d["place"] * s.amplitude, "lower": s.rest - d["place"] * s.amplitude}
    chosen = {f"stop_{end}": at for end, at in ends.items() if d["side"] in (end, "both")}
    stiffness = 1.5 * k * s.Ks / float(np.sqrt(s.amplitude))
    return chosen | {"stop": stiffness, "stop_restitution": d["restitution"] / s.speed}


def _saturation(s: Scales, k: float, d: Shape) -> Values:
    """Cut 5 % of the largest torque at a size of 1: w/τ = (1 + (τ/L)^n)^(-1/n)."""
    kept, n = 1.0 / (1.0 + 0.05 * k), d["sharpness"]
    return {"limit": s.torque / float(kept**-n - 1.0) ** (1.0 / n), "limit_sharpness": n}


def _tendon(s: Scales, k: float, d: Shape) -> Values:
    stiffness, rotor = 6.0 * s.Ks / k, d["rotor"] * s.inertia
    damping = 2.0 * d["damping"] * float(np.sqrt(stiffness * rotor))
    joint = {"inertia": s.inertia - rotor, "rotor_inertia": rotor, "tendon": stiffness, "tendon_damping": damping}
    stretch = s.torque / stiffness
    return joint | {"tendon_hysteresis": d["hysteresis"] * stiffness, "tendon_travel": d["travel"] * stretch}


def _gear(s: Scales, k: float, d: Shape) -> Values:
    waves = {"gear_second": d["second"], "gear_third": d["third"], "gear_change": d["change"]}
    slow = {"gear_change_number": d["number"] / d["slower"] / s.amplitude}
    return {"gear": 0.06 * k * s.torque} | _wave("gear", s, d) | waves | slow


def _warming(name: str, excess: float, d: Shape) -> Values:
    shape = {f"{name}_share": d["share"], f"{name}_fast": d["fast_s"], f"{name}_slow": d["slow_s"]}
    return {name: d["sign"] * excess} | shape


def _bump(s: Scales, k: float, d: Shape) -> Values:
    height = 0.6 * k if d["sign"] > 0 else -min(0.6 * k, 0.9)
    place = {"bump_centre": s.rest + d["place"] * s.amplitude, "bump_width": d["width"] * s.amplitude}
    return {"bump": height} | place


def _neighbour(s: Scales, k: float, d: Shape) -> Values:
    natural, inertia = d["frequency_rad_s"], s.inertia
    coupling = min(0.9, 0.35 * float(np.sqrt(k))) * inertia
    known = {"neighbour_inertia": inertia, "neighbour_coupling": coupling}
    spring = {"neighbour_stiffness": inertia * natural**2, "neighbour_travel": d["travel"] * s.amplitude}
    return known | spring | {"neighbour_damping": 2.0 * d["damping"] * inertia * natural}


FORMULAS: dict[str, Formula] = {
    "progressive_spring": lambda s, k, d: {
        "spring": 0.12 * k * d["sign"] * s.Ks * s.amplitude,
        "spring_travel": s.amplitude,
        "spring_power": d["power"],
    },
    "one_sided_spring": lambda s, k, d: {"bend": 0.1 * k * d["sign"] * s.Ks, "bend_width": d["width"] * s.amplitude},
    "contact_stop": _stop,
    "smooth_saturation": _saturation,
    "smooth_dead_band": lambda s, k, d: {"dead": 0.1 * k * s.torque, "dead_sharpness": d["sharpness"]},
    "power_gain": lambda s, k, d: {"gain": 0.1 * k, "gain_torque": s.torque, "gain_power": d["power"]},
    "delay_and_lag": lambda _, k, d: {"delay": 0.03 * k * d["delay"], "lag": 0.03 * k * (1.0 - d["delay"])},
    "viscoelastic_tendon": _tendon,
    "varying_play": lambda s, k, d: {"play": 0.03 * k * s.amplitude, "play_change": d["change"]} | _wave("play", s, d),
    "gear_wave": _gear,
    "trapezoid_ripple": lambda s, k, d: {"ripple": 0.1 * k, "ripple_steepness": d["steepness"]} | _wave("ripple", s, d),
    "friction_bump": _bump,
    "load_friction": lambda s, k, d: {
        "load_drive": 0.3 * k,
        "load_back": 0.3 * k * d["back"],
        "load_torque": s.torque,
    },
    "coulomb_warming": lambda _, k, d: _warming("warm", min(0.5 * k, 0.9) if d["sign"] < 0 else 0.5 * k, d),
    "viscous_warming": lambda _, k, d: _warming("oil", min(0.4 * k, 3.0), d),
    "power_drag": lambda s, k, d: {
        "drag": 0.5 * k * s.sigma2 * s.speed,
        "drag_speed": s.speed,
        "drag_power": d["power"],
    },
    "directional_friction": lambda s, k, d: {
        "direction": d["sign"] * min(0.3 * k, 0.9),
        "direction_speed": d["speed"] * s.speed,
    },
    "directional_damping": lambda s, k, d: {
        "damping_direction": d["sign"] * min(0.3 * k, 0.95),
        "damping_direction_speed": d["speed"] * s.speed,
    },
    "bouc_wen_cable": lambda s, k, d: {
        "cable": 0.15 * k * s.Ks,
        "cable_travel": d["travel"] * s.amplitude,
        "cable_power": d["power"],
        "cable_share": d["share"],
    },
    "two_wave_eccentricity": lambda _, k, d: {
        "eccentric": 0.1 * k,
        "eccentric_phase": d["phase"],
        "eccentric_second": 0.1 * k * d["second"],
        "eccentric_second_phase": d["second_phase"],
    },
    "triangle_lines": lambda s, k, d: {"lines": 0.015 * k * s.amplitude} | _wave("lines", s, d),
    "logarithmic_gain": lambda _, k, d: {
        "fading": 0.06 * k * d["sign"] / float(np.log1p(RUN_S / d["time_s"])),
        "fading_time": d["time_s"],
    },
    "power_bias": lambda s, k, d: {
        "bias": 0.06 * k * d["sign"] * s.torque,
        "bias_time": RUN_S,
        "bias_power": d["power"],
    },
    "beating_disturbance": lambda s, k, d: {
        "beat": 0.04 * k * s.torque,
        "beat_frequency": d["frequency_rad_s"],
        "beat_phase": d["phase"],
        "beat_depth": d["depth"],
        "beat_slow": d["slow_rad_s"],
    },
    "bending_clock": lambda _, k, d: {
        "clock": 0.002 * k * d["sign"],
        "clock_bend": 0.002 * k * d["sign"] * d["bend"],
        "clock_time": RUN_S,
    },
    "turning_inertia": lambda _, k, d: {
        "swing": min(0.3 * k, 0.8),
        "swing_number": d["number"],
        "swing_phase": d["phase"],
    },
    "hardening_neighbour": _neighbour,
    "cosh_damping": lambda s, k, d: {
        "cosh_damping": k * s.sigma2 / (float(np.cosh(1.0 / d["width"])) - 1.0),
        "cosh_width": d["width"] * s.amplitude,
    },
    "twice_lagged_stribeck": lambda _, k, __: {"stribeck_time": 0.05 * k},
}
"""Parameters of ``stranger.c`` [SI] from scales of the joint, a size [1] and what the size leaves open, by name."""
