"""Effects that a residual torque cannot tell from a named one: final model and rounds in, `Rival`s out.

A name is certain only where the runs tell it from the effects that could stand in its place. Each effect of the final
model is exchanged for every other effect that gained in the round that added it, all parameters are refitted, and the
two models are compared by stretches as everywhere in this search. An exchange over which the final model does not
predict better, as an effect has to that is added, is a rival.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from haptid.discrepancy.torque.fit import TorqueFit, fit_model
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.discrepancy.torque_search.candidate import TorqueCandidate, compare_candidates
from haptid.model.effects.effect import id_of
from haptid.support.errors import NumericalError


@dataclass(frozen=True, slots=True, kw_only=True)
class Rival:
    """A model in which another effect stands in the place of a named one.

    Parameters
    ----------
    replaces
        Key of the effect of the final model.
    key
        Key of the effect in its place.
    model
        The model with that effect, refitted.
    behind
        Twice the gain in log score of predicted stretches by which the final model is ahead; negative where the rival
        is.
    """

    replaces: str
    key: str
    model: TorqueFit
    behind: float


def find_rivals(
    study: TorqueStudy, final: TorqueFit, rounds: Sequence[tuple[TorqueCandidate, Sequence[TorqueCandidate]]]
) -> tuple[Rival, ...]:
    """Find the effects that the runs cannot tell from the named ones.

    Parameters
    ----------
    study
        Study of the joint.
    final
        Model with the named effects.
    rounds
        Candidate that was added in each round, with all candidates of that round.

    Returns
    -------
    tuple of Rival
        Rivals, the nearest to the final model first.
    """
    named = {effect.key for effect in final.effects}
    ids = {effect.id for effect in final.effects}
    found = []
    for taken, candidates in rounds:
        if taken.key not in named:
            continue
        for other in candidates:
            if other.plausible and id_of(other.key) not in ids:
                rival = _exchange(study, final, taken, other)
                if rival is not None:
                    found.append(rival)
    return tuple(sorted(found, key=lambda rival: rival.behind))


def _exchange(study: TorqueStudy, final: TorqueFit, taken: TorqueCandidate, other: TorqueCandidate) -> Rival | None:
    """Return the rival that ``other`` is in the place of ``taken``; None where the runs tell the two apart."""
    kept = tuple(effect for effect in final.effects if effect.key != taken.key)
    new = next(effect for effect in other.model.effects if effect.key == other.key)
    own = {effect.key for effect in other.model.effects} == {new.key, *(effect.key for effect in kept)}
    # The candidate's own model may still hold effects of earlier rounds that elimination left out, or lack later ones.
    start = other.model.values if own else final.values | {q.id: other.model.values[q.id] for q in new.parameters}
    try:
        # A candidate's refit stops early, the final model's does not: compared as they are, the latter would be ahead.
        exchanged = fit_model(study, (*kept, new), start)
    except NumericalError:
        return None
    ahead = compare_candidates(taken.key, exchanged, final)
    if ahead.predicts_better:
        return None
    return Rival(replaces=taken.key, key=other.key, model=exchanged, behind=ahead.evidence)
