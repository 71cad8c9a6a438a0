"""Finish the best of preliminary fits: fit them to the end, judge them, and add those that may be as good or better.

A fit with the same effects that was finished before is taken again, unless the new start is clearly ahead of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from haptid.discrepancy.candidate.candidate import Candidate
from haptid.discrepancy.candidate.refit import fit_briefly, settle
from haptid.discrepancy.candidate.trial import Trial, chosen, keys_of
from haptid.discrepancy.detect.inner_step import at_step
from haptid.discrepancy.fit.homotopy import through_homotopy
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.search.trials.judging import judge_candidate, judge_on_other_path
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect, match_parameters
from haptid.support.numbers import plain


def finish_best(
    s: Searcher,
    current: Candidate,
    begun: Sequence[Solution],
    most: int = THRESHOLDS.search.most_finished_if_none_adequate,
    *,
    freed: bool = False,
) -> list[Trial]:
    """Finish the best preliminary fits on top of ``current``.

    Parameters
    ----------
    s
        Tools of the search.
    current
        Model that the fits extend.
    begun
        Preliminary fits.
    most
        Largest number of fits to the end where none is adequate.
    freed
        Whether the preliminary fits began at the first guesses; otherwise the best trial is fitted from there too.

    Returns
    -------
    list of Trial
        Judged trials, with those of equal equations.
    """
    trials: list[Trial] = []
    ahead: dict[frozenset[str], Candidate] = {}
    ready = s.best_of_each(begun)
    while ready and len(trials) < THRESHOLDS.search.most_finished_fits:
        # Once one trial is adequate, only its rivals matter: fits that come near its likelihood. Until then the
        # number of fits is bounded, and more tightly where even the best are far from noise.
        if any(t.adequate for t in trials):
            ready = _keep_near_the_best(s, trials, ready)
        else:
            far = all(t.left.far for t in trials)
            if len(trials) >= (min(THRESHOLDS.search.most_finished_if_all_far, most) if far else most):
                break
        if ready:
            best = ready.pop(0)
            if (made := find_finished(s, current, best)) is None:
                fit_ahead(s, ahead, [best, *(ready if trials else ())])
                made = finish(s, current, best, ahead.pop(keys_of(best)))
            trials.append(made)
    trials = add_twins(s, current, trials)
    return trials if freed else add_best_freed(s, current, trials)


def _keep_near_the_best(s: Searcher, trials: Sequence[Trial], ready: Sequence[Solution]) -> list[Solution]:
    """Keep preliminary fits that come near the best trial; a declared rival may be further from its optimum."""
    best = max(trials, key=lambda t: t.solution.log_likelihood).solution
    alike = s.rivals(best.effects[-1].key) if best.effects else set()
    near = best.log_likelihood - THRESHOLDS.search.rival_log_likelihood_gap
    far = best.log_likelihood - THRESHOLDS.search.declared_rival_log_likelihood_gap
    return [fit for fit in ready if fit.log_likelihood > (far if fit.effects[-1].id in alike else near)]


def add_twins(s: Searcher, current: Candidate, trials: list[Trial]) -> list[Trial]:
    """Add trials with the same equations as an adequate one, started at its optimum: neither of them is better.

    Parameters
    ----------
    s
        Tools of the search.
    current
        Model that the trials extend.
    trials
        Judged trials.

    Returns
    -------
    list of Trial
        The trials with those of equal equations after them.
    """
    found = list(trials)
    known = {keys_of(t.solution) for t in found if t.adequate}
    for solution in [t.solution for t in trials if t.adequate]:
        for effects, ids in find_twins(s, solution.effects):
            if (keys := frozenset(e.key for e in effects)) in known:
                continue
            known.add(keys)
            values = solution.values | {new: solution.values[old] for old, new in ids.items()}
            begun = fit_briefly(s.study, effects, solution.noise, values, solution.x0)
            s.simulations += begun.calls * len(s.study.fitted)
            found.append(finish(s, current, begun))
    return found


def find_twins(s: Searcher, effects: tuple[Effect, ...]) -> Iterator[tuple[tuple[Effect, ...], dict[str, str]]]:
    """Yield models with the same equations under the names of another catalogue effect.

    Parameters
    ----------
    s
        Tools of the search.
    effects
        Effects of a model.

    Yields
    ------
    effects, names
        The model with another effect in the place of one, and the parameters of that effect by those of the
        replaced one.
    """
    ids = [e.id for e in effects]
    for k, effect in enumerate(effects):
        for other in s.catalogue.values():
            if other.id not in ids and (names := match_parameters(effect, other)) is not None:
                yield (*effects[:k], other, *effects[k + 1 :]), names


def find_finished(s: Searcher, current: Candidate, begun: Solution) -> Trial | None:
    """Return a finished trial with the same effects where a new start promises no better one.

    Parameters
    ----------
    s
        Tools of the search.
    current
        Model that the trial extends.
    begun
        Preliminary fit from the new start.

    Returns
    -------
    Trial or None
        The best finished trial with these effects; None where there is none, or where the new start is clearly
        ahead.
    """
    before = s.finished.get(keys_of(begun), ())
    for trial in sorted(before, key=lambda t: t.candidate.criterion)[:1]:
        effects, values = trial.solution.effects, trial.solution.values
        rough = at_step(s.study, s.study.factory.coarse)
        # Likelihoods under different noise models cannot be compared, so the finished fit takes a few steps under
        # the noise, and at the inner step, of the new start.
        there = fit_briefly(rough, effects, begun.noise, values, trial.solution.x0)
        s.simulations += there.calls * len(s.study.fitted)
        ahead = begun.log_likelihood - there.log_likelihood
        lead = THRESHOLDS.search.least_lead_of_restart_over_excess * (trial.left.energy - trial.left.dof)
        if ahead < max(THRESHOLDS.candidate.least_gain_in_criterion / 2, lead):
            return trial.against(current)
    return None


def add_best_freed(s: Searcher, current: Candidate, trials: list[Trial]) -> list[Trial]:
    """Add a fit of the best trial through homotopy from the first guesses, where it is near noise but not adequate.

    Parameters
    ----------
    s
        Tools of the search.
    current
        Model that the trials extend.
    trials
        Judged trials.

    Returns
    -------
    list of Trial
        The trials, with the new fit after them where it promises to be better.

    Notes
    -----
    The fit of the nominal model may have moved friction into a corner to make up for a discrepancy (Fs = Fc, where
    vs has no meaning), and a fit that starts there can stay there. No such fit is needed where a trial is adequate
    with its effects earned, or with one effect too many.
    """
    there = any(t.adequate and (t.acceptable or len(t.solution.effects) > 1) for t in trials)
    if there or all(t.left.far for t in trials):
        return trials
    best = chosen(trials) or min(trials, key=lambda t: t.candidate.criterion)
    effects = best.solution.effects
    # A second finished trial with the same effects came from another start already.
    if len(s.finished.get(keys_of(best.solution), ())) > 1:
        return trials
    own = {q.id: best.solution.values[q.id] for e in effects for q in e.parameters}
    freed, calls = through_homotopy(
        at_step(s.study, s.study.factory.coarse),
        effects,
        own,
        tolerance=THRESHOLDS.fit.rough_tolerance_chi2,
    )
    s.simulations += calls * len(s.study.fitted)
    better = np.isfinite(freed.log_likelihood) and find_finished(s, current, freed) is None
    return [*trials, finish(s, current, freed)] if better else trials


def fit_ahead(s: Searcher, ahead: dict[frozenset[str], Candidate], ready: Sequence[Solution]) -> None:
    """Fit the first of ``ready`` to the end unless this was done, and the likely next ones side by side with it.

    Parameters
    ----------
    s
        Tools of the search.
    ahead
        Candidates that were fitted ahead, by the keys of their effects; new ones are added.
    ready
        Preliminary fits, best first.

    Notes
    -----
    The caller passes the very first fit alone, since it is the likeliest to be adequate. A fit that is never used
    changes neither the results nor the count of simulations.
    """
    if keys_of(ready[0]) not in ahead:
        # As many fits as threads run at once; the further ones may be needed next. On one thread nothing is fitted
        # ahead.
        fresh = [ready[0], *(fit for fit in ready[1:] if keys_of(fit) not in s.finished)][: s.study.threads]
        done = s.each(lambda study, fit: settle(study, fit.effects, fit), fresh)
        ahead.update(zip(map(keys_of, fresh), done, strict=True))


def finish(s: Searcher, current: Candidate, begun: Solution, fitted: Candidate | None = None) -> Trial:
    """Fit a preliminary fit to the end, and judge it.

    Parameters
    ----------
    s
        Tools of the search.
    current
        Model that the fit extends.
    begun
        Preliminary fit.
    fitted
        The candidate, where it was fitted to the end already.

    Returns
    -------
    Trial
        Judged trial; it is kept in ``finished``.
    """
    made = judge_candidate(s, fitted or settle(s.study, begun.effects, begun), current)
    made = judge_on_other_path(s, made, current)
    s.finished.setdefault(keys_of(begun), []).append(made)
    noise = f"{plain(float(np.sqrt(made.left.energy / made.left.dof)))} times the noise is left"
    s.tell("judged " + "+".join(made.solution.keys), figures=noise)
    return made
