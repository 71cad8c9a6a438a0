"""Put another friction law into the nominal model of a study: `Study` and its fit in, `Study` and first guesses out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from haptid.discrepancy.study.study import Study, scales_over, usable, within_reach
from haptid.model.friction.law import Sliding
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.parameter_table import joint_parameters


def under_law(study: Study, law: str, values: Mapping[str, float]) -> Study:
    """Return the study of the same joint whose nominal model has another friction law.

    Parameters
    ----------
    study
        Study of one joint alone.
    law
        Id of the other friction law.
    values
        Fitted parameters of the nominal model under the law of the study, by id.

    Returns
    -------
    Study
        Parameters that both laws have keep their ranges and priors; first guesses of the others follow from the
        friction in gross sliding that was fitted. There is no fit to begin at.

    Raises
    ------
    InputError
        Where there is no such law, or an effect of the user's own asks for a slot that it lacks.
    """
    asked, other = law_named(study.base.friction[0]), law_named(law)
    roles = asked.roles
    scales = scales_over(study.fitted, values, roles)
    # Stiction for the level of Coulomb friction: a Stribeck curve that was bent to another law's needs may end at 0.
    sliding = Sliding(
        coulomb=values[roles.stiction], viscous=values[roles.viscous], inertia=values["inertia"],
        travel=2 * scales.position, speed=scales.speed,
    )  # fmt: skip
    guesses, own = other.guess(sliding), {q.id: q for q in study.base.parameters}
    table = joint_parameters(prismatic=study.prismatic, friction=law)
    parameters = tuple(
        own.get(q.id, q.but(initial=min(max(guesses.get(q.id, q.initial), q.lower), q.upper)))
        for q in table
        if q.id in own or q.id in other.ids
    )
    # Those of a drive stand in no table of a law.
    parameters += tuple(q for id, q in own.items() if id not in asked.ids and id not in {row.id for row in table})
    base = joint_equations(
        study.joint, parameters=parameters, prismatic=study.prismatic, friction=law, drive=study.base.drive
    )
    known = {q.id: {"lower": q.lower, "upper": q.upper} for q in parameters if q.id in own}
    narrowed = within_reach(base, study.fitted).with_parameters(known)
    return replace(study, base=narrowed, catalogue=usable(study.catalogue, other), carried=None)
