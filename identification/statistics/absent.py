"""Terms that the data do not need: `Fit` in, `Fit` out with the status of each and a sentence on how large it may be.

A model holds spring, gravity and stiction whether the joint has them or not. Where the 95 % interval of such a term
holds 0, the term is not ``identified``: it is told as absent, with the end of the interval. Ids of a term:

- spring: Ks, whose equilibrium epos has no meaning without it. Their product Ks·epos is a constant torque, which a
  joint without a spring may have: its interval is told where it does not hold 0;
- gravity: gravity_cos and gravity_sin together (a joint that slides has only the first);
- stiction: Fs − Fc, without which the Stribeck velocity vs has no meaning;
- presliding: where it ends within far less than the mean of all rows tells, σ/√n, its parameters are those of the inner
  step and of the noise, whatever the curvature of the cost says.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.result.fit import Fit
from haptid.identification.thresholds import THRESHOLDS
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import law_named
from haptid.support.linear_algebra import symmetric_inverse
from haptid.support.numbers import plain, write_interval

SPRING = ("Ks", "epos")
"""Ids of the stiffness and the equilibrium of a single joint's spring."""

NO_SPRING_SEEN, NO_GRAVITY_SEEN = "no spring is seen", "no gravity is seen"
"""Beginnings of the sentences on terms that are absent."""
NO_SPRING: dict[str, object] = {"initial": 0.0, "lower": 0.0, "upper": 1.0, "fixed": True}
"""Entries of both parameters that leave a spring out."""


def with_absent_terms(fit: Fit, largest: float = np.inf, resolved: Sequence[float] = ()) -> Fit:
    """Tell spring, gravity, stiction and presliding that the data do not need as absent.

    Parameters
    ----------
    fit
        Fit with its final covariance. Parameters that are fixed or have a prior are left as they are.
    largest
        Largest torque of the runs [N m], or [N] of a prismatic joint: gravity or stiction whose interval reaches beyond
        is not told as absent, for the runs say nothing of it.
    resolved
        Standard deviation of the mean position of all rows, for each joint [rad] ([m]); empty where the fit is none of
        positions.

    Returns
    -------
    Fit
        The parameters of absent terms are ``unidentifiable``; a sentence for each is added to the warnings.
    """
    joints = fit.equations.joints
    # Equations that are solved for the torque have no joints, but the friction of one.
    suffixes = id_suffixes(joints) or ("",)
    statuses, said = dict(fit.statuses), list(fit.warnings)
    for k, (law, suffix) in enumerate(zip(fit.equations.friction, suffixes, strict=False)):
        name = f"joint {joints[k]}: " if suffix else ""
        roles = law_named(law).roles
        stiction = (roles.stiction, roles.coulomb) if roles.stiction != roles.coulomb else ()
        for absent, sentence in (
            _spring(fit, f"Ks{suffix}", f"epos{suffix}"),
            _gravity(fit, [f"gravity_cos{suffix}", f"gravity_sin{suffix}"], largest),
            _stiction(fit, [f"{id}{suffix}" for id in stiction], f"{roles.stribeck_velocity}{suffix}", largest),
        ):
            statuses |= {id: "unidentifiable" for id in absent if statuses.get(id) in ("identified", "at_bound")}
            said += [name + sentence] if absent else []
        if k < len(resolved):
            absent, sentence = _presliding(fit, law_named(law), suffix, resolved[k])
            told = [id for id in absent if statuses[id] == "identified"]
            statuses |= dict.fromkeys(told, "unidentifiable")
            said += [name + sentence] if told else []
    return fit.but(statuses=statuses, warnings=tuple(said))


def absent_ids(fit: Fit) -> tuple[str, ...]:
    """Return the parameters of terms that the runs show to be absent: no further run can tell them.

    Parameters
    ----------
    fit
        Fit with the warnings of `with_absent_terms`.

    Returns
    -------
    tuple of str
        Those of the spring, and of gravity.
    """
    spring, gravity = (
        any(text.startswith(words) for text in fit.warnings) for words in (NO_SPRING_SEEN, NO_GRAVITY_SEEN)
    )
    own = [id for id in fit.statuses if id.startswith("gravity_")]
    return (*(SPRING if spring else ()), *(own if gravity else ()))


def without_absent_spring(fit: Fit, own: Sequence[str]) -> Equations | None:
    """Leave out the spring of a single joint where the 95 % interval of its stiffness holds 0.

    Parameters
    ----------
    fit
        Fit with its final covariance.
    own
        Ids of the parameters that nobody stated: a stated spring stays.

    Returns
    -------
    Equations or None
        With the estimates as first guesses and the spring fixed at 0; None where there is none, or where it is seen.
    """
    if not set(SPRING) <= set(own) or not _spring(fit, *SPRING)[0]:
        return None
    kept = {
        q.id: {"initial": fit.values[q.id], "lower": q.lower, "upper": q.upper}
        for q in fit.equations.parameters
        if q.id in fit.free
    }
    return fit.equations.with_parameters(kept | dict.fromkeys(SPRING, NO_SPRING))


def without_spring(equations: Equations, own: Sequence[str]) -> Equations | None:
    """Leave out the spring of a single joint.

    Parameters
    ----------
    equations
        Equations of the joint.
    own
        Ids of the parameters that nobody stated: a stated spring stays.

    Returns
    -------
    Equations or None
        With the spring fixed at 0; None where there is none, or where it was stated.
    """
    stiffness = [q for q in equations.parameters if q.id == SPRING[0]]
    if not set(SPRING) <= set(own) or not stiffness or stiffness[0].fixed or stiffness[0].lower > 0:
        return None
    return equations.with_parameters(dict.fromkeys(SPRING, NO_SPRING))


def _open(fit: Fit, ids: Sequence[str]) -> list[str]:
    """Return the ids of fitted parameters without a prior."""
    return [id for id in ids if id in fit.free and fit.equations.parameter(id).prior is None]


def _spring(fit: Fit, stiffness: str, equilibrium: str) -> tuple[list[str], str]:
    ids = _open(fit, [stiffness])
    # A range that the user begins above 0 says that there is a spring.
    if not ids or fit.equations.parameter(stiffness).lower > 0:
        return [], ""
    value, reach = fit.values[stiffness], _reach(fit, [stiffness], np.ones(1))
    if abs(value) > reach:
        return [], ""
    unit = fit.equations.parameter(stiffness).unit
    most = f"|{stiffness}| < {plain(abs(value) + reach)} {unit} with 95 %"
    return [stiffness, equilibrium], f"{NO_SPRING_SEEN}: {most}{_constant_torque(fit, stiffness, equilibrium)}"


def _constant_torque(fit: Fit, stiffness: str, equilibrium: str) -> str:
    """Tell the torque Ks·epos of a spring that is not seen, where its 95 % interval does not hold 0.

    The error is propagated to first order: d(Ks·epos) = epos·dKs + Ks·depos.
    """
    if equilibrium not in fit.free:
        return ""
    k, q = fit.values[stiffness], fit.values[equilibrium]
    torque, reach = k * q, _reach(fit, [stiffness, equilibrium], np.array([q, k]))
    if abs(torque) <= reach:
        return ""
    unit = fit.equations.parameter(stiffness).unit.split("/")[0]
    interval = write_interval(torque - reach, torque + reach, 2)
    return f"; a constant torque is: {stiffness}·{equilibrium} = {interval} {unit} with 95 %"


def _gravity(fit: Fit, ids: Sequence[str], largest: float) -> tuple[list[str], str]:
    chosen = _open(fit, ids)
    stated = any(fit.values.get(id, 0.0) != 0.0 for id in ids if id not in fit.free)
    if not chosen or stated:
        return [], ""
    places = [fit.free.index(id) for id in chosen]
    values = np.array([fit.values[id] for id in chosen])
    covariance = fit.covariance[np.ix_(places, places)]
    if float(values @ symmetric_inverse(covariance) @ values) > THRESHOLDS.largest_chi_squared_of_no_gravity:
        return [], ""
    limit = max(abs(fit.values[id]) + _reach(fit, [id], np.ones(1)) for id in chosen)
    unit = fit.equations.parameter(chosen[0]).unit
    if limit > largest:
        return chosen, f"gravity is not told by these runs, whose torque ends at {plain(largest)} {unit}"
    return chosen, f"{NO_GRAVITY_SEEN}: below {plain(limit)} {unit} with 95 %"


def _stiction(fit: Fit, ids: Sequence[str], velocity: str, largest: float) -> tuple[list[str], str]:
    if len(_open(fit, ids)) < 2:
        return [], ""
    stiction, coulomb = ids
    rise, reach = fit.values[stiction] - fit.values[coulomb], _reach(fit, ids, np.array([1.0, -1.0]))
    if rise > reach:
        return [], ""
    unit = fit.equations.parameter(stiction).unit
    sentence = f"no stiction is seen: {stiction} - {coulomb} < {plain(rise + reach)} {unit} with 95 %"
    if velocity in fit.free:
        # A rise that ends at a lower speed shows for a shorter time, and so may be larger.
        fastest = fit.equations.parameter(velocity)
        sentence += f", if it ends at {velocity} = {plain(fit.values[velocity])} {fastest.unit}"
    if rise + reach > largest:
        sentence = f"stiction is not told by these runs, whose torque ends at {plain(largest)} {unit}"
    return [stiction, velocity], sentence


def _presliding(fit: Fit, law: FrictionLaw, suffix: str, resolved: float) -> tuple[list[str], str]:
    stiffness = f"{law.roles.stiffness}{suffix}"
    if not law.roles.stiffness or not _open(fit, [stiffness]):
        return [], ""
    length = law.presliding_length(law.values(fit.values, suffix))
    if length >= THRESHOLDS.largest_unseen_presliding * resolved:
        return [], ""
    unit = fit.equations.parameter(stiffness).unit.partition("/")[2]
    told = f"no presliding is seen: it ends within {plain(length)} {unit}"
    return _open(fit, [f"{id}{suffix}" for id in law.without_presliding]), told


def _reach(fit: Fit, ids: Sequence[str], weights: np.ndarray) -> float:
    """Return the half width of the 95 % interval of a weighted sum of parameters."""
    places = [fit.free.index(id) for id in ids]
    variance = float(weights @ fit.covariance[np.ix_(places, places)] @ weights)
    return THRESHOLDS.standard_errors_of_interval * float(np.sqrt(max(variance, 0.0)))
