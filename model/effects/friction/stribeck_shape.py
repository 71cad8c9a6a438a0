"""A Stribeck curve that is no Gaussian of the speed: of another exponent, or with a tail.

*Exponent*: exp(−|v/vs|^δ). Bo and Pavelescu (1982) find δ between 0.5 and 2, Armstrong-Hélouvry (1991) larger ones. The
slope is infinite at rest where δ < 1, so vs/10⁶ is added to the speed in the square.

*Tail*: (1 + c·(v/vs)²)^(−1/c), which is the Gaussian at c = 0 and the curve of Hess and Soom (1990) at c = 1.
"""

import sympy as sp

from haptid.model.effects.effect import Effect, fade_in, fall, parameter

e, c = sp.symbols("stribeck_exponent_change stribeck_tail", real=True)
REST = sp.Float(1e-12)
"""Added to (v/vs)², so that its logarithm exists at rest."""
LEAST = sp.Float(1e-2)
"""Tail below which the argument is blended to the Gaussian's."""


def _shape(variant: str, formula: str, amplitude: tuple[str, str, float, float, float], argument: sp.Expr) -> Effect:
    id, words, initial, lower, upper = amplitude
    return Effect(
        id="stribeck_shape",
        variant=variant,
        title="Stribeck curve of another shape",
        formula=formula,
        lives_in="velocity",
        side="friction",
        parameters=(parameter(id, "1", words, initial, lower, upper),),
        rivals=("quadratic_drag", "friction_lag"),
        stribeck_argument=argument,
    )


EFFECTS = (
    _shape(
        "exponent",
        "Fc + (Fs − Fc)·exp(−|q̇/vs|^(2 + e))",
        (e.name, "exponent of the Stribeck curve, less 2", 0.5, -1.7, 8.0),
        sp.exp((2 + e) / 2 * sp.log(fall + REST)),
    ),
    _shape(
        "tail",
        "Fc + (Fs − Fc)·(1 + c·(q̇/vs)²)^(−1/c)",
        (c.name, "tail of the Stribeck curve", 0.3, 0.0, 5.0),
        fade_in(c, LEAST, sp.log(1 + c * fall) / c, fall),
    ),
)
