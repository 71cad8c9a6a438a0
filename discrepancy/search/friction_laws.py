"""Try other friction laws in the nominal model: `Study` and its nominal `Solution` in, `OtherLaw`s out.

Dry friction that follows another law than the model's looks like several missing effects at once, and no effect of the
catalogue leaves noise alone beside the wrong law. So the other laws are fitted where the nominal model fails.

1. Begin at the nominal optimum, with the law's further parameters at its own guesses, at a tenth of those that have a
   unit, and with all its parameters at its guesses.
2. Fit each start briefly, the best for longer, and to the end where it gains something.
3. Stop at a law with no more parameters that leaves noise alone, or next to nothing of the residual of the law of the
   study. Keep the laws that leave far less of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from haptid.discrepancy.candidate.refit import likeliest, settle
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.inner_step import at_step, step_for
from haptid.discrepancy.detect.omnibus import omnibus
from haptid.discrepancy.fit.nominal_fit import NominalFit
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.study.under_law import under_law
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.friction.registry import law_named, laws
from haptid.noise.correlation import Noise
from haptid.support.errors import InputError
from haptid.support.listener import Progress


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherLaw:
    """A study under another friction law, with its nominal model.

    Parameters
    ----------
    study
        Study under that law, at the inner step whose error is invisible there.
    base
        Fit of its nominal model under white noise.
    own
        Fit of its nominal model under the noise estimated from its residuals.
    passes
        Whether it leaves noise alone, as far as the tests tell that need no scores of the catalogue.
    simpler
        Whether it does so, or leaves next to nothing of the excess, with no more parameters than the law of the study:
        what no further parameter was needed for is no effect that a law imitates.
    """

    study: Study
    base: NominalFit
    own: Solution
    passes: bool
    simpler: bool

    @property
    def fits(self) -> tuple[Solution, Solution]:
        """Nominal model under white noise, and under its own."""
        return self.base.solution, self.own

    def leaves_less_than(self, chi2: float) -> bool:
        """Say whether the law explains more than a fit beside the law of the study.

        Parameters
        ----------
        chi2
            ‖r‖² of that fit under white noise.

        Returns
        -------
        bool
            Where the law leaves noise alone, whether its ‖r‖² is less; else whether its excess is less by the factor
            `largest_excess_over_best_effect`.
        """
        own = self.base.solution.chi2
        return own < chi2 if self.passes else _leaves_far_less(own, chi2, self.study.rows)


def other_laws(study: Study, start: Trial, white: Solution, tell: Progress) -> tuple[OtherLaw, ...]:
    """Fit the nominal model under every other friction law.

    Parameters
    ----------
    study
        Study of one joint alone.
    start
        Nominal model under its own noise.
    white
        Nominal model under white noise.
    tell
        Told of each step.

    Returns
    -------
    tuple of OtherLaw
        Laws under which the nominal model leaves noise alone, those first that need no more parameters, then those
        that leave at most the share `largest_excess_under_other_law` of the excess energy; the least ‖r‖² first among
        each.
    """
    most = study.rows + THRESHOLDS.search.largest_excess_under_other_law * (white.chi2 - study.rows)
    found = []
    others = [law for law in laws() if law != study.base.friction[0]]
    for number, law in enumerate(others):
        tell("other friction laws", number, len(others), law)
        try:
            other = _fit(study, start, white, law)
        except InputError:  # an effect of the user's own asks for what the law lacks
            continue
        if other is None or not (other.passes or other.base.solution.chi2 < most):
            continue
        found.append(other)
        if other.simpler:
            break
    return tuple(sorted(found, key=lambda other: (not other.simpler, not other.passes, other.base.solution.chi2)))


def _fit(study: Study, start: Trial, white: Solution, law: str) -> OtherLaw | None:
    """Fit one law; None where it explains hardly more than the law of the study."""
    other = under_law(study, law, white.values)
    best, calls = _best_start(other, starts_under_law(other, white))
    least = max(
        THRESHOLDS.search.least_gain_under_other_law_chi2,
        THRESHOLDS.search.least_gain_under_other_law_over_excess * (white.chi2 - study.rows),
    )
    if not best.finite or white.chi2 - best.chi2 < least:
        return None
    return _to_the_end(study, start, white, other, best, calls)


def _best_start(other: Study, starts: Iterable[Mapping[str, float]]) -> tuple[Solution, int]:
    """Fit each start briefly and the best for longer; return it with the number of simulations of all runs."""
    few, budget = THRESHOLDS.candidate.first_try_simulations, THRESHOLDS.search.simulations_of_a_start_under_other_law
    begun = [solve(other, (), Noise(), values, iterations=few) for values in starts]
    first = likeliest(*begun)
    best = solve(other, (), Noise(), first.values, x0=first.x0, iterations=budget)
    return best, sum(one.calls for one in (*begun, best))


def law_from(study: Study, start: Trial, white: Solution, law: str, values: Mapping[str, float]) -> OtherLaw:
    """Fit the nominal model under one other friction law, whatever it gains there.

    Parameters
    ----------
    study
        Study of one joint alone.
    start
        Nominal model under its own noise, with the law of the study.
    white
        The same under white noise.
    law
        Id of the other law.
    values
        Parameters by id at which the fit begins.

    Returns
    -------
    OtherLaw
    """
    other = under_law(study, law, white.values)
    begun = solve(other, (), Noise(), values, iterations=THRESHOLDS.search.simulations_of_a_start_under_other_law)
    return _to_the_end(study, start, white, other, begun, begun.calls)


def law_that_leaves_less(
    study: Study, start: Trial, white: Solution, law: str, values: Mapping[str, float], than: float
) -> OtherLaw | None:
    """Fit the nominal model under another law, and to the end only where it comes to leave far less than an effect.

    Parameters
    ----------
    study, start, white, law
        As for `law_from`.
    values
        Parameters by id of one more start beside those of every other law.
    than
        ‖r‖² that the effect leaves under white noise.

    Returns
    -------
    OtherLaw or None
        None where the effect leaves about as little.
    """
    other = under_law(study, law, white.values)
    best, calls = _best_start(other, (values, *starts_under_law(other, white)))
    if not _leaves_far_less(best.chi2, than, study.rows):
        return None
    found = _to_the_end(study, start, white, other, best, calls)
    return found if found.simpler or found.leaves_less_than(than) else None


def _leaves_far_less(chi2: float, than: float, rows: int) -> bool:
    return chi2 - rows < THRESHOLDS.search.largest_excess_over_best_effect * (than - rows)


def _to_the_end(study: Study, start: Trial, white: Solution, other: Study, best: Solution, calls: int) -> OtherLaw:
    """Fit the nominal model under another law to the end, and judge it."""
    other = at_step(other, step_for(other, best, share=THRESHOLDS.detect.step_error_share_of_excess))
    solution = solve(other, (), Noise(), best.values, x0=best.x0)
    calls += solution.calls
    candidate = settle(other, (), solution)
    trial = Trial(candidate=candidate, left=omnibus(other, candidate.solution)).against(start.candidate)
    base = NominalFit(solution=solution, costs=(solution.chi2,), reached=1, calls=calls + candidate.calls)
    passes = trial.passes and trial.acceptable
    fewer = candidate.parameters <= start.candidate.parameters
    little = THRESHOLDS.search.largest_excess_under_right_law * (white.chi2 - study.rows)
    explains = passes or solution.chi2 - study.rows < little
    return OtherLaw(study=other, base=base, own=candidate.solution, passes=passes, simpler=explains and fewer)


def starts_under_law(other: Study, white: Solution) -> Iterator[dict[str, float]]:
    """Yield start values of a nominal model under another friction law.

    Parameters
    ----------
    other
        Study under that law.
    white
        Nominal model under the law of the study.

    Yields
    ------
    dict
        Parameters by id; what a start leaves out begins at its first guess.
    """
    law, known = law_named(other.base.friction[0]), white.values
    own = [q for q in other.base.parameters if q.id in law.ids and q.id not in known]
    smaller = THRESHOLDS.search.smaller_start_divisor
    shared = {id: value for id, value in known.items() if id not in law.ids}
    yield known | {q.id: q.initial for q in own}
    if any(q.unit != "1" for q in own):
        yield known | {q.id: q.initial if q.unit == "1" else q.initial / smaller for q in own}
    yield shared
