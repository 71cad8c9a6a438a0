"""The search's tools: entries begun on top of a model, side by side, and the best of them fitted to the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from haptid.discrepancy.candidate.candidate import BETTER, Trial, chosen, keys_of
from haptid.discrepancy.candidate.parameter_constancy import constancy
from haptid.discrepancy.candidate.refit import FIRST, Candidate, begin, continue_refit, settle, significance, starts_of
from haptid.discrepancy.detect.inner_step import at_step
from haptid.discrepancy.detect.omnibus import omnibus
from haptid.discrepancy.detect.score_tests import Scan, Score, scan
from haptid.discrepancy.detect.signatures import Signatures
from haptid.discrepancy.fit.homotopy import (
    Guided,
    at_fine,
    hold_shapes,
    release_observer,
    start_under_observer,
    through_homotopy,
)
from haptid.discrepancy.fit.solution import ROUGH, Solution, solve
from haptid.discrepancy.study.simulators import COARSE, SKETCH
from haptid.discrepancy.study.study import Study
from haptid.model.effects.effect import Effect, match_parameters
from haptid.noise.correlation import Path
from haptid.support.processes.threads import map_threads

S = TypeVar("S")
T = TypeVar("T")
Tried = tuple[tuple[Effect, ...], Guided]
"""Effects with their fit under the observer."""

PROMISING = 8
"""Entries that are gone on with after a first try."""
LATER = 20
"""Entries that are begun on top of an effect: by then the scores of the catalogue may be trusted for a first sieve."""
FINISHED, HOPELESS, FEW = 8, 4, 2
"""Most fits to the end of one step, how many of them where none leaves only noise, and where all are far from it."""
MOST = 3
"""Most effects at once."""
CLOSE = 40.0
"""Log-likelihood from the best within which a begun fit is finished as a rival."""
SIEVED, BRIEF, WIDE = 2, 12, 10.0
"""Gains of the homotopy under which entries that are fitted anew are compared, most simulations under each, and the
tolerance in squares over the noise."""
BESIDE = 12
"""Entries that are fitted anew beside another one: those that score best there."""
APART, AHEAD = 3, 4
"""Gains of the homotopy that tell entries well apart, and how many are gone on with then."""
NEWS = 0.05
"""Share of what a finished fit left over that a new start with the same effects must be ahead by to be finished too."""


@dataclass(slots=True)
class Searcher:
    """The search's tools about one joint: study, signatures at its base, and the running count of simulations.

    Parameters
    ----------
    study
        The study at the inner step of its readings.
    entries, found, tests
        Catalogue in SI units, its signatures at the base, and the number of independent tests that it amounts to.
    tell
        Hears of the progress.
    simulations
        Runs simulated in fits so far.
    finished
        Fits to the end by the keys of their effects.
    extended
        Keys of the effects on top of which the catalogue has been tried, not its few best scores only.
    cut
        Whether combinations were left out for want of effort.
    """

    study: Study
    entries: dict[str, Effect]
    found: Signatures
    tests: float
    tell: Callable[[str], None]
    simulations: int = 0
    finished: dict[frozenset[str], list[Trial]] = field(default_factory=dict)
    extended: set[frozenset[str]] = field(default_factory=set)
    cut: bool = False

    def spent(self) -> bool:
        """Whether as many runs were simulated as the study's effort allows; if so, something is left out now."""
        if self.simulations < self.study.effort:
            return False
        if not self.cut:
            self.tell(f"{self.simulations} runs simulated: no further combinations")
        self.cut = True
        return True

    def scan(self, solution: Solution) -> Scan:
        """Score the catalogue about ``solution``."""
        return scan(self.study, solution, self.found, self.entries, tests=self.tests)

    def trial(self, candidate: Candidate, before: Candidate | None = None) -> Trial:
        """Judge a candidate, against ``before`` where it extends one."""
        self.simulations += candidate.calls * len(self.study.fitted)
        solution = candidate.solution
        wald, at_bound = significance(solution)
        judged = Trial(candidate=candidate, left=omnibus(self.study, solution), worth=wald, at_bound=at_bound)
        if judged.passes:
            judged = replace(judged, left_p=self.scan(solution).family_p)
        if judged.adequate and solution.effects:
            p, calls = constancy(self.study, solution)
            self.simulations += calls
            judged = replace(judged, constant_p=p)
        return judged if before is None else judged.against(before)

    def step(
        self, current: Candidate, begun: Sequence[Solution], most: int = HOPELESS, *, freed: bool = False
    ) -> list[Trial]:
        """Extend ``current``: of what was begun on top of it, finish the best, ``most`` if none leaves only noise.

        What was begun from the first guesses is ``freed`` already.
        """
        trials: list[Trial] = []
        ahead: dict[frozenset[str], Candidate] = {}
        ready = self.best_of_each(begun)
        while ready and len(trials) < FINISHED:
            if any(t.adequate for t in trials):
                limit = max(t.solution.log_likelihood for t in trials) - CLOSE
                ready = [s for s in ready if s.log_likelihood > limit]
            elif len(trials) >= (min(FEW, most) if all(t.left.far for t in trials) else most):
                break
            if ready:
                best = ready.pop(0)
                if (made := self.known(current, best)) is None:
                    self.look_ahead(ahead, [best, *(ready if trials else ())])
                    made = self.finish(current, best, ahead.pop(keys_of(best)))
                trials.append(made)
        trials = self.with_twins(current, trials)
        return trials if freed else self.with_best_freed(current, trials)

    def with_twins(self, current: Candidate, trials: list[Trial]) -> list[Trial]:
        """Begin models with the same equations as one that leaves only noise at its optimum: neither is the better."""
        found = list(trials)
        known = {keys_of(t.solution) for t in found if t.adequate}
        for solution in [t.solution for t in trials if t.adequate]:
            for effects, ids in self.twins(solution.effects):
                if (keys := frozenset(e.key for e in effects)) in known:
                    continue
                known.add(keys)
                values = solution.values | {new: solution.values[old] for old, new in ids.items()}
                begun = solve(self.study, effects, solution.noise, values, x0=solution.x0, iterations=FIRST)
                self.simulations += begun.calls * len(self.study.fitted)
                found.append(self.finish(current, begun))
        return found

    def twins(self, effects: tuple[Effect, ...]) -> Iterator[tuple[tuple[Effect, ...], dict[str, str]]]:
        """Yield models in which another entry with the same equations takes the place of one effect.

        With each come the other entry's parameters by those of the effect.
        """
        ids = [e.id for e in effects]
        for k, effect in enumerate(effects):
            for other in self.entries.values():
                if other.id not in ids and (names := match_parameters(effect, other)) is not None:
                    yield (*effects[:k], other, *effects[k + 1 :]), names

    def known(self, current: Candidate, begun: Solution) -> Trial | None:
        """Return the fit to the end with the same effects where the new start promises nothing better, else None.

        Both are compared under the noise of the new start, the finished one after a few steps under it.
        """
        before = self.finished.get(keys_of(begun), ())
        for trial in sorted(before, key=lambda t: t.candidate.criterion)[:1]:
            effects, values = trial.solution.effects, trial.solution.values
            rough = at_step(self.study, COARSE)
            there = solve(rough, effects, begun.noise, values, x0=trial.solution.x0, iterations=FIRST)
            self.simulations += there.calls * len(self.study.fitted)
            ahead = begun.log_likelihood - there.log_likelihood
            if ahead < max(BETTER / 2, NEWS * (trial.left.energy - trial.left.dof)):
                return trial.against(current)
        return None

    def best_of_each(self, *begun: Sequence[Solution]) -> list[Solution]:
        """Return the most likely fit of every last entry, the most likely first."""
        first: dict[str, Solution] = {}
        for found in sorted((s for each in begun for s in each), key=self.rank):
            first.setdefault(found.effects[-1].key, found)
        return list(first.values())

    def with_best_freed(self, current: Candidate, trials: list[Trial]) -> list[Trial]:
        """Fit the best trial again through homotopy from the first guesses, where it is near noise alone but not there.

        The base fit may have taken friction into a corner to make up for what is missing (Fs = Fc, where vs means
        nothing); a fit that starts there can stay there. What leaves only noise with one effect too many is there.
        """
        there = any(t.adequate and (t.acceptable or len(t.solution.effects) > 1) for t in trials)
        if there or all(t.left.far for t in trials):
            return trials
        best = chosen(trials) or min(trials, key=lambda t: t.candidate.criterion)
        effects = best.solution.effects
        if len(self.finished.get(keys_of(best.solution), ())) > 1:
            return trials
        own = {q.id: best.solution.values[q.id] for e in effects for q in e.parameters}
        freed, calls = through_homotopy(at_step(self.study, COARSE), effects, own, tolerance=ROUGH)
        self.simulations += calls * len(self.study.fitted)
        better = np.isfinite(freed.log_likelihood) and self.known(current, freed) is None
        return [*trials, self.finish(current, freed)] if better else trials

    def ready(self, solution: Solution, most: int | None = None) -> list[Solution]:
        """Return fits of single entries on top of ``solution``, the most likely first; coarse steps, not the end.

        By default all entries are tried on top of the base, and `LATER` of the best scores on top of an effect; no more
        than the study says, and the rivals of the best one beside them.
        """
        most = min(most or (LATER if solution.effects else len(self.entries)), self.study.most or len(self.entries))
        if most >= PROMISING:
            self.extended.add(keys_of(solution))
        rough = self.side_by_side(COARSE)
        scored = self.beside(solution, self.scan(solution))
        likely = self.rivals(scored[0].key) if scored else set()
        fresh = {s.key: s for k, s in enumerate(scored) if k < most or self.entries[s.key].id in likely}
        tried = [self.entries[key] for key in fresh]
        begun = self.mapped(partial(begin, rough, solution), tried, fresh.values())
        begun = self.ranked(begun)
        named = self.rivals(begun[0].effects[-1].key) if begun else set()
        promising = begun[:PROMISING] + [s for s in begun[PROMISING:] if s.effects[-1].id in named]
        scores = [fresh[s.effects[-1].key] for s in promising]
        done = self.mapped(partial(continue_refit, rough, solution), promising, scores)
        for found in sorted(done, key=lambda pair: self.rank(pair[0])):
            self.tell(f"  {found[0].effects[-1].key} {found[0].log_likelihood:.1f}")
        self.simulations += (sum(s.calls for s in begun) + sum(calls for _, calls in done)) * len(self.study.fitted)
        return self.ranked(s for s, _ in done)

    def rivals(self, key: str) -> set[str]:
        """Return ids of the entries that an entry has for rivals, and of those that have it for one."""
        entry = self.entries[key]
        return {*entry.rivals, *(other.id for other in self.entries.values() if entry.id in other.rivals)}

    def beside(self, solution: Solution, scored: Scan) -> list[Score]:
        """Return the scores of entries that are not in ``solution`` yet, in any variant, the best first."""
        return [s for s in scored.scores if self.entries[s.key].id not in solution.ids]

    def anew(self, scored: Scan, onto: Solution) -> list[Solution]:
        """Return fits through homotopy of base, the effects of ``onto`` and one entry, the most likely first.

        They begin at the first guesses of the base and the effects as they are in ``onto``: a base that took a large
        effect upon itself may lie so far from the joint that no fit from there finds back, and no score there tells.
        The observer holds the simulation near the readings: there entries are compared, and ever fewer go on. Beside
        another effect those are tried that score best: what is missing there scores first, as long as that one is real.
        """
        self.extended.add(keys_of(onto))
        rough = self.side_by_side(COARSE)
        values = {q.id: q.initial for q in self.study.base.parameters}
        values |= {q.id: onto.values[q.id] for e in onto.effects for q in e.parameters}
        chosen: list[tuple[Effect, ...]] = []
        starts: list[dict[str, float]] = []
        for score in self.beside(onto, scored)[: BESIDE if onto.effects else self.study.most]:
            effect = self.entries[score.key]
            for own in starts_of(effect, score):
                chosen.append((*onto.effects, effect))
                starts.append(values | own)
        begun = self.mapped(partial(_sketched, self.side_by_side(SKETCH)), chosen, starts)
        sieved = self.mapped(partial(_sieved, rough), best_first(begun)[:PROMISING])
        done = self.mapped(partial(_released, rough), best_first(sieved)[:AHEAD])
        calls = sum(low.calls for _, low in (*begun, *sieved)) + sum(calls for _, calls in done)
        self.simulations += calls * len(self.study.fitted)
        return self.ranked(s for s, _ in done)

    def side_by_side(self, step: float) -> Study:
        """Return the study at an inner step [s] with one thread a fit: for fits of several entries side by side."""
        return replace(at_step(self.study, step), threads=1)

    def mapped(self, function: Callable[..., T], *arguments: Iterable[Any]) -> list[T]:
        """Return ``function`` of every tuple of arguments, side by side on the study's threads."""
        return map_threads(function, *arguments, threads=self.study.threads)

    def ranked(self, fits: Iterable[Solution]) -> list[Solution]:
        """Return those of the fits that did not leave the numbers, the one to look at first before the others."""
        return sorted((s for s in fits if np.isfinite(s.log_likelihood)), key=self.rank)

    def rank(self, solution: Solution) -> float:
        """BIC up to a constant: the smaller, the sooner a fit is looked at."""
        return effect_parameters(solution) * float(np.log(self.study.rows)) - 2.0 * solution.log_likelihood

    def look_ahead(self, ahead: dict[frozenset[str], Candidate], ready: Sequence[Solution]) -> None:
        """Fit the first of ``ready`` to the end unless it is there, and what may come next side by side with it.

        The first of all is fitted alone, for it is the likeliest to leave only noise; what was fitted in vain changes
        neither results nor the count of simulations.
        """
        if keys_of(ready[0]) not in ahead:
            fresh = [ready[0], *(s for s in ready[1:] if keys_of(s) not in self.finished)][: self.study.threads]
            done = self.each(lambda study, s: settle(study, s.effects, s), fresh)
            ahead.update(zip(map(keys_of, fresh), done, strict=True))

    def each(self, function: Callable[[Study, S], T], chosen: Sequence[S]) -> list[T]:
        """Return ``function`` of the study and each of ``chosen``: several side by side, on one thread each."""
        study = self.study if len(chosen) == 1 else replace(self.study, threads=1)
        return self.mapped(partial(function, study), chosen)

    def finish(self, current: Candidate, begun: Solution, fitted: Candidate | None = None) -> Trial:
        """Fit to the end what was begun on top of ``current`` (if it is not ``fitted``), judge it and tell of it."""
        made = self.trial(fitted or settle(self.study, begun.effects, begun), current)
        made = self.on_its_path(made, current)
        self.finished.setdefault(keys_of(begun), []).append(made)
        self.tell(
            f"{'+'.join(made.solution.keys)}: gain {made.gain:.0f}, unseen {made.held_out:.0f}, "
            f"left over {made.left.energy:.0f}/{made.left.dof:.0f}"
        )
        return made

    def on_its_path(self, made: Trial, before: Candidate | None = None) -> Trial:
        """Put the scatter on the other path where that alone leaves only noise.

        Whether amplitudes scatter in the torque or in the reading is known only once both have been fitted: a torque's
        scatter is linear in the reading about its own most probable amplitudes alone.
        """
        scatters = made.solution.noise.scatters
        if made.adequate or not scatters or made.left.far:
            return made
        other: Path = "torque" if scatters[0].path == "reading" else "reading"
        turned = self.trial(settle(self.study, made.solution.effects, made.solution, paths=(other,)), before)
        return turned if turned.adequate else made


def _sketched(study: Study, effects: tuple[Effect, ...], values: Mapping[str, float]) -> Tried:
    """Fit under the highest gains, briefly, with the last effect in the shape in which it begins."""
    *onto, last = effects
    near = start_under_observer(study, (*onto, hold_shapes(last, values)), values).down_to(SIEVED, BRIEF, WIDE)
    return effects, near


def _sieved(study: Study, tried: Tried) -> Tried:
    """Go on at the step of ``study``, down to where entries are told apart."""
    effects, low = tried
    return effects, at_fine(study, effects, low).down_to(APART)


def _released(study: Study, tried: Tried) -> tuple[Solution, int]:
    """Go on to the end, roughly."""
    return release_observer(study, *tried, ROUGH)


def best_first(found: Sequence[Tried]) -> list[Tried]:
    """Return the guided fit of least cost of every last entry, the least first."""
    best = {both[-1].key: (both, low) for both, low in sorted(found, key=lambda pair: -pair[1].cost)}
    return sorted(best.values(), key=lambda pair: pair[1].cost)


def effect_parameters(solution: Solution) -> int:
    """Count the free parameters of a solution's effects."""
    return sum(not q.fixed for e in solution.effects for q in e.parameters)
