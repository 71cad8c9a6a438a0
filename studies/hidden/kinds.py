"""Which names of the catalogue stand for a kind of disturbance of the stranger, written down before any search saw one.

The formulas differ on purpose; a name is right if it is the kind that was hidden. Where the catalogue splits a kind by
a formula alone (a gain that falls with torque; a torque that comes late) either name is right.
"""

from __future__ import annotations

from collections.abc import Iterable

LAW = "friction_law"
"""Name of what is hidden where a refit of LuGre friction cannot follow the friction law."""
KINDS: dict[str, tuple[str, ...]] = {
    "progressive_spring": ("cubic_spring",),
    "one_sided_spring": ("asymmetric_spring",),
    "contact_stop": ("end_stop",),
    "smooth_saturation": ("amplifier_saturation", "amplifier_nonlinear_gain"),
    "smooth_dead_band": ("amplifier_dead_band",),
    "power_gain": ("amplifier_nonlinear_gain",),
    "delay_and_lag": ("amplifier_lag", "time_delay"),
    "viscoelastic_tendon": ("tendon_elasticity",),
    "varying_play": ("backlash",),
    "gear_wave": ("cogging",),
    "trapezoid_ripple": ("torque_ripple",),
    "friction_bump": ("position_dependent_friction",),
    "load_friction": ("load_dependent_friction",),
    "coulomb_warming": ("coulomb_drift",),
    "viscous_warming": ("viscous_drift",),
    "power_drag": ("quadratic_drag",),
    "directional_friction": ("asymmetric_coulomb",),
    "directional_damping": ("asymmetric_viscous",),
    "bouc_wen_cable": ("cable_hysteresis",),
    "two_wave_eccentricity": ("encoder_eccentricity",),
    "triangle_lines": ("encoder_ripple",),
    "logarithmic_gain": ("gain_drift",),
    "power_bias": ("torque_bias_drift",),
    "beating_disturbance": ("periodic_disturbance",),
    "bending_clock": ("clock_error",),
    "turning_inertia": ("configuration_inertia",),
    "hardening_neighbour": ("lock_compliance",),
    "cosh_damping": ("position_dependent_viscous",),
    "twice_lagged_stribeck": ("friction_lag",),
}
"""Names of the catalogue by the stranger's name; the first stands for the kind in figures."""


def kinds_of(names: Iterable[str], hidden: Iterable[str]) -> tuple[str, ...]:
    """Return names of the catalogue with those that are right for what is hidden replaced by their kind.

    Parameters
    ----------
    names
        Names of the catalogue.
    hidden
        Names of the stranger's disturbances that a case hides.

    Returns
    -------
    tuple of str
        The first name of the kind for each name that is right, any other name as it is.

    Examples
    --------
    >>> kinds_of(["time_delay", "cogging"], ["delay_and_lag"])
    ('amplifier_lag', 'cogging')
    """
    stands = {id: KINDS[name][0] for name in hidden for id in KINDS[name]}
    return tuple(stands.get(name, name) for name in names)
