"""The search: from the base, one effect at a time, until what is left is noise or no entry helps any more.

Base fit, noise from its own residuals, inner step from its own error; then test, score, refit, add. A better base found
from the winner's optimum starts it again; with several effects, each is exchanged and removed once more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from haptid.discrepancy.candidate.candidate import BETTER, Trial, chosen, keys_of
from haptid.discrepancy.candidate.refit import score_candidate, settle, sharpen_jumps
from haptid.discrepancy.detect.inner_step import SMALL_SHARE, at_step, step_for
from haptid.discrepancy.detect.score_tests import Scan, scan
from haptid.discrepancy.detect.signatures import Signatures, signatures
from haptid.discrepancy.fit.nominal_fit import Base, fit_base
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.backward_elimination import exchange_effects, prune_stand_ins, without_each
from haptid.discrepancy.search.contenders import fit_contenders
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.search.step_refinement import Closer, closer
from haptid.discrepancy.search.tools import FEW, HOPELESS, MOST, PROMISING, Searcher
from haptid.discrepancy.study.study import Study
from haptid.model.effects.effect import Effect
from haptid.noise.correlation import Colour, Noise

Way = Callable[[Searcher, Solution], list[Trial]]
"""How a second effect is looked for on top of a fit with one."""
LEADS = 3
"""Leading fits, each of another entry, on which a second effect is tried where no other way leaves only noise."""
ROUNDED = 0.01
"""Share of its threshold over which a jump is rounded where a second effect is sought: sharper ones hold fits up."""
CLEAR = 4
"""Best scores that are tried on top of a leading fit as it is, before many from the first guesses."""
PART = 0.2
"""Least share of the gap, or of the gain of the effect before, for which a third effect is looked for."""
SCATTERED = 0.1
"""Largest share of the base's squares that is left where scatter, or an entry, makes up for most of a large gap."""
STUCK = 10.0
"""Decrease of the base's cost, found from a winner's optimum, that shows the base fit to have been stuck."""


def search(study: Study, *, seed: int = 0, starts: int = 8, tell: Callable[[str], None] = lambda _: None) -> Search:
    """Look for what is missing in the base model of ``study``; ``tell`` hears of the progress."""
    study, base = fit_nominal_model(study, seed=seed, starts=starts, tell=tell)
    found, s = _search_from(study, base, tell)
    if found.best.solution.effects and (better := _refit_nominal(found)) is not None:
        tell("the base fit was stuck: again from the better minimum")
        base = replace(base, solution=better)
        again, s = _search_from(study, base, tell, known=found)
        found = _with_cost_of(found, again)
    if (finer := closer(s, found.best, found.trials)) is not None:
        if finer.best is None or finer.best.adequate < found.best.adequate:
            again, s = _search_from(finer.searcher.study, base, tell)
        else:
            again, s = _at_finer_step(found, finer, finer.best), finer.searcher
        found = _with_cost_of(found, again)
    before = s.simulations
    contenders = fit_contenders(s, found.best, found.plain)
    simulations = found.simulations + s.simulations - before
    return replace(found, contenders=tuple(contenders), simulations=simulations)


def fit_nominal_model(study: Study, *, seed: int, starts: int, tell: Callable[[str], None]) -> tuple[Study, Base]:
    """Fit the base; return the study at the inner step whose error is invisible there, and the fit."""
    tell("base fit")
    base = fit_base(study, starts=starts, seed=seed)
    return at_step(study, step_for(study, base.solution, share=SMALL_SHARE)), base


def under_own_noise(study: Study, base: Base) -> tuple[Solution, Solution]:
    """Return the base under white noise, and under the noise that is estimated from it."""
    white = solve(study, (), Noise(), base.solution.values, x0=base.solution.x0)
    return white, settle(study, (), white).solution


def score_catalogue(
    study: Study, plain: Solution, tell: Callable[[str], None]
) -> tuple[dict[str, Effect], Signatures, Scan]:
    """Return the catalogue in SI units, its signatures at the base, and their scores."""
    tell("signatures of the catalogue")
    entries = study.in_si(plain.values)
    found = signatures(study, plain, list(entries.values()))
    first = scan(study, plain, found, entries)
    tell(f"{len(found.points)} signatures, {first.tests:.0f} independent tests")
    return entries, found, first


def _search_from(
    study: Study, base: Base, tell: Callable[[str], None], known: Search | None = None
) -> tuple[Search, Searcher]:
    """Search from one minimum of the base; keep what is ``known`` where it still gains over a base that lacks."""
    white, plain = under_own_noise(study, base)
    entries, found, first = score_catalogue(study, plain, tell)
    s = Searcher(study, entries, found, first.tests, tell, base.calls * len(study.fitted) + found.simulations)
    start = s.on_its_path(s.trial(score_candidate(study, plain, plain.calls)))
    if known is not None and not start.adequate and known.best.candidate.criterion < start.candidate.criterion - BETTER:
        trials, best = known.trials, known.best
        less = known.less if len(known.less) > 1 else dict.fromkeys(known.less, start.candidate)
    else:
        made, best = _forward(s, start, white, first)
        best, less, more = exchange_effects(s, best, start)
        trials = (*made, *more)
    result = Search(
        study=study, base=base, plain=start, scan=first, trials=trials, best=best, less=less,
        simulations=s.simulations, cut=s.cut,
    )  # fmt: skip
    return result, s


def _with_cost_of(earlier: Search, found: Search) -> Search:
    return replace(found, simulations=earlier.simulations + found.simulations, cut=earlier.cut or found.cut)


def _at_finer_step(found: Search, finer: Closer, best: Trial) -> Search:
    """Take over what a finer step makes of the models near the best; base and the others are as good at the old one."""
    fitted = {t.solution.keys for t in finer.trials}
    others = [t for t in found.trials if t.solution.keys not in fitted]
    same = best.solution.keys == found.best.solution.keys
    less = found.less if same else without_each(finer.searcher, best, found.plain)
    return replace(
        found, study=finer.searcher.study, trials=(*finer.trials, *others), best=best, less=less,
        simulations=finer.searcher.simulations,
    )  # fmt: skip


def _forward(s: Searcher, start: Trial, white: Solution, first: Scan) -> tuple[list[Trial], Trial]:
    """Add effects until nothing but noise is left, or no entry helps; begin under white noise.

    A large gap passes for correlated or scattering noise; so each candidate's noise is estimated from what it leaves.
    """
    if start.adequate and start.solution.noise == Noise():
        return [], start
    trials, leads = _first_step(s, start, white, first)
    winner = chosen(trials)
    best = winner if winner is not None and (not start.adequate or simpler(winner, start)) else start
    while best is not start and not best.adequate and len(best.solution.effects) < MOST and beats(best, start):
        if s.spent():
            break
        made = s.step(best.candidate, s.ready(best.solution), FEW if len(best.solution.effects) > 1 else HOPELESS)
        made += prune_stand_ins(s, made, start)
        trials += made
        if (winner := chosen(made)) is None:
            break
        best, before = winner, best
        if not (best.adequate or gets_on(best, before)):
            break
    if not any(t.adequate for t in (best, *trials)):
        made = _two_at_once(s, leads, start, _anew)
        trials += made
        best = chosen([t for t in made if t.adequate]) or best
    if best is start and not any(t.acceptable for t in trials):
        best = replace(start, refuted=True)
    return trials, best


def _first_step(s: Searcher, start: Trial, white: Solution, first: Scan) -> tuple[list[Trial], list[Solution]]:
    """Try single entries, two at once where all of them leave far more than noise.

    The cheaper comes first: the best scores on top of the leading fits, then many from the first guesses on top of the
    best of them, then single entries from the first guesses.

    Returns
    -------
    trials, leads
        What was fitted to the end, and the leading fits under white noise on which the catalogue was not tried anew.
    """
    few = start.adequate
    begun: list[Solution] = []
    trials: list[Trial] = []
    pairs: list[Trial] = []
    for fits in _ways(s, start, white):
        trials += s.step(start.candidate, fits[:1] if few else fits)
        if few or explains_all(trials):
            return trials, []
        if fits and fits[0].noise == Noise():
            begun = s.best_of_each(begun, fits)
            pairs += _two_at_once(s, leads_of(begun, LEADS), start, _clear) if all_far(trials) else []
            if explains_all(pairs):
                return trials + pairs, []
    pairs += _two_at_once(s, leads_of(begun, 1), start, _anew) if all_far(trials) else []
    if explains_all(pairs):
        return trials + pairs, []
    s.tell("entries anew from the first guesses")
    fits = s.anew(first, white)
    begun = s.best_of_each(begun, fits)
    trials += s.step(start.candidate, fits)
    leads = [lead for lead in leads_of(begun, LEADS) if keys_of(lead) not in s.extended]
    if not explains_all(trials) and all_far(trials):
        pairs, leads = pairs + _two_at_once(s, leads, start, _anew), []
    return trials + pairs, leads


def explains_all(trials: Sequence[Trial]) -> bool:
    """Whether one leaves nothing but noise and has earned its effects."""
    return any(t.adequate and t.acceptable for t in trials)


def all_far(trials: Sequence[Trial]) -> bool:
    """Whether something was tried, and all of it leaves far more than noise."""
    return bool(trials) and all(t.left.far for t in trials)


def leads_of(begun: Sequence[Solution], most: int) -> list[Solution]:
    """Return the leading fits, the best of every last entry in whatever variant."""
    first_of = {lead.effects[-1].id: lead for lead in reversed(begun)}
    return [lead for lead in begun if lead is first_of[lead.effects[-1].id]][:most]


def _two_at_once(s: Searcher, leads: Sequence[Solution], start: Trial, way: Way) -> list[Trial]:
    """Extend leading fits under white noise, each though it leaves a gap: the noise is judged beside two effects.

    What a second effect leaves passes for noise of any kind and size, under which the first one may gain nothing. A
    jump that is still rounded off would hide the second one. Where the first one comes to nothing beside the second, it
    was a stand-in for it.
    """
    made: list[Trial] = []
    for lead in leads:
        if s.spent():
            break
        rounded = solve(s.study, lead.effects, Noise(), lead.values, x0=lead.x0)
        first, calls = sharpen_jumps(s.study, rounded, rounded.calls, ROUNDED)
        s.simulations += calls * len(s.study.fitted)
        both = way(s, first)
        made += [*both, *prune_stand_ins(s, both, start)]
        if explains_all(made):
            break
    return made


def _clear(s: Searcher, first: Solution) -> list[Trial]:
    """Try the best scores on top of one effect as it was fitted: beside one that is real the other scores best."""
    s.tell(f"{'+'.join(first.keys)} and what scores best beside it")
    return s.step(score_candidate(s.study, first, first.calls), s.ready(first, CLEAR), FEW)


def _anew(s: Searcher, first: Solution) -> list[Trial]:
    """Try many from the first guesses: the base may have taken the second effect upon itself."""
    s.tell(f"{'+'.join(first.keys)} and another")
    return s.step(score_candidate(s.study, first, first.calls), s.anew(s.scan(first), first), FEW, freed=True)


def _ways(s: Searcher, start: Trial, white: Solution) -> Iterator[list[Solution]]:
    """Yield fits of single entries from the base: under white noise, then under scatter alone.

    Each way is gone when it is asked for, that under scatter where the base's makes up for most of the gap and no entry
    does: there a gap under white noise says nothing of the entries.
    """
    yield (fits := s.ready(white, PROMISING if start.adequate else None))
    noise = start.solution.noise.but(colour=Colour())
    most = SCATTERED * white.chi2
    instead = start.solution.chi2 < most < min((fit.chi2 for fit in fits), default=np.inf)
    if noise.scatters and (not start.left.far or instead):
        s.tell("entries under scatter")
        yield s.ready(solve(s.study, (), noise, start.solution.values, x0=start.solution.x0))


def beats(now: Trial, start: Trial) -> bool:
    """Whether it beats the base under a noise of its own, which may hold all of the gap as scatter."""
    return start.candidate.criterion - now.candidate.criterion > BETTER


def gets_on(now: Trial, before: Trial) -> bool:
    """Whether one effect more has taken a good part of what was left, so that another one may take the rest."""
    left, was = (t.left.energy - t.left.dof for t in (now, before))
    return left < (1.0 - PART) * was or now.gain > PART * before.gain


def simpler(winner: Trial, start: Trial) -> bool:
    """Whether the noise of an adequate winner needs less than that of the base: an effect was taken for noise."""
    return winner.adequate and winner.solution.noise.terms < start.solution.noise.terms


def _refit_nominal(found: Search) -> Solution | None:
    """Refit the base from the winner's optimum; return it where it beats the base that the search began with."""
    winner, plain = found.best.solution, found.plain.solution
    again = solve(found.study, (), plain.noise, winner.values, x0=winner.x0)
    return again if again.log_likelihood > plain.log_likelihood + STUCK / 2 else None
