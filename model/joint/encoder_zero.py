"""Encoder zeros that differ from run to run: `Equations` in, `Equations` with one state a joint more out.

An incremental encoder is zeroed where the joint rests when the drive is switched on, anywhere within the band in which
friction holds it. The reading is then y = q + z₀ with the joint's position q and a constant z₀ of the run. The position
states here are readings, and every force acts at y − z₀: x₀ starts at the first reading, whatever z₀ is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

from haptid.model.equations.equations import Equations, State
from haptid.model.equations.fmu_names import ENCODER_ZERO, of_joint

ID = "encoder_zero"
"""Beginning of the ids of these states; the joint's number follows."""


def with_encoder_zeros(equations: Equations, std: Sequence[float]) -> Equations:
    """Add the encoder's zero of every joint as a constant state, whose start value differs from run to run.

    Parameters
    ----------
    equations
        Equations of the free joints.
    std
        Standard deviation of each joint's zero over the runs [rad], or [m] for a prismatic joint; shape (n_joints,).

    Returns
    -------
    Equations
        Equations whose positions are the encoders' readings. The zeros are the states behind the velocities.
    """
    n = len(equations.joints)
    positions = equations.states[:n]
    zeros = tuple(
        State(
            id=f"{ID}_{j}", unit=at.unit, description=f"reading of joint {j} at position 0",
            nominal=spread, start_std=spread, structured=of_joint(j, ENCODER_ZERO),
        )
        for j, at, spread in zip(equations.joints, positions, std, strict=True)
    )  # fmt: skip
    shifted = {at.symbol: at.symbol - zero.symbol for at, zero in zip(positions, zeros, strict=True)}

    def insert(old: Sequence[Any], new: Sequence[Any]) -> tuple[Any, ...]:
        # Behind positions and velocities: states that an effect adds stay the last ones.
        return (*old[: 2 * n], *new, *old[2 * n :])

    still = (sp.S.Zero,) * n
    widened = replace(
        equations,
        states=insert(equations.states, zeros),
        rhs=insert(equations.rhs, still),
        rates=insert(equations.rates, still),
    )
    # The outputs stay: the position states are what the encoders read.
    return widened.substitute(shifted, outputs=False)


def without_encoder_zeros(equations: Equations) -> Equations:
    """Take encoder zeros out again: readings are positions.

    Parameters
    ----------
    equations
        Equations with or without encoder zeros.

    Returns
    -------
    Equations
        The same equations at z₀ = 0, without these states.
    """
    gone = set(zero_states(equations))
    at_zero = {equations.states[k].symbol: sp.S.Zero for k in gone}

    def keep(entries: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(entry for k, entry in enumerate(entries) if k not in gone)

    still = equations.substitute(at_zero)
    return replace(still, states=keep(still.states), rhs=keep(still.rhs), rates=keep(still.rates))


def zero_states(equations: Equations) -> tuple[int, ...]:
    """Find the states that are encoder zeros.

    Parameters
    ----------
    equations
        Equations of some free joints.

    Returns
    -------
    tuple of int
        Their indices among the states, in the order of the joints; empty where the zero is known.
    """
    return tuple(k for k, state in enumerate(equations.states) if state.id.startswith(f"{ID}_"))


def is_felt(equations: Equations, joint: int) -> bool:
    """Say whether a force depends on a joint's position, so that its encoder's zero can be seen at all.

    Parameters
    ----------
    equations
        Equations of the free joints.
    joint
        Index among the free joints.

    Returns
    -------
    bool
        Whether an acceleration has the position in it, once all parameters that are fixed at 0 are put in.
    """
    n = len(equations.joints)
    absent = {q.symbol: 0 for q in equations.parameters if q.fixed and q.initial == 0.0}
    expanded = equations.without_definitions()
    position = equations.states[joint].symbol
    return any(position in sp.sympify(e).subs(absent).free_symbols for e in expanded.rhs[n : 2 * n])
