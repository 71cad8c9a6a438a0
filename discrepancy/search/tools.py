"""Provide the steps of the search: a model and catalogue effects in, judged `Trial`s out.

1. Score the catalogue on the model's residual (`Searcher.scan`).
2. Begin single effects on top of the model, side by side, and continue the promising ones (`Searcher.ready`), or fit
   them through homotopy from the first guesses (`Searcher.anew`).
3. Fit the best of them to the end and judge them (`Searcher.step`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from haptid.discrepancy.candidate.candidate import Trial, chosen, keys_of
from haptid.discrepancy.candidate.parameter_constancy import constancy
from haptid.discrepancy.candidate.refit import Candidate, begin, continue_refit, settle, significance, starts_of
from haptid.discrepancy.detect.inner_step import at_step
from haptid.discrepancy.detect.omnibus import omnibus
from haptid.discrepancy.detect.score_tests import Scan, Score, scan
from haptid.discrepancy.detect.signatures import Signatures
from haptid.discrepancy.fit.homotopy import (
    Guided,
    at_fine,
    release_observer,
    start_holding_last_shape,
    through_homotopy,
)
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect, match_parameters
from haptid.noise.correlation import Path
from haptid.support.listener import Progress
from haptid.support.numbers import plain
from haptid.support.processes.threads import map_threads

S = TypeVar("S")
T = TypeVar("T")
Tried = tuple[tuple[Effect, ...], Guided]
"""Effects of a model, with its fit under the observer."""


def first_tests(study: Study, candidate: Candidate, nominal_excess: float = 0.0) -> Trial:
    """Judge a candidate by the tests that need no scores of the catalogue.

    Parameters
    ----------
    study
        Study with the fitted runs.
    candidate
        Refitted model.
    nominal_excess
        Excess of the nominal model over the stated noise, as `Prediction.excess` [1].

    Returns
    -------
    Trial
        Without scores and without the constancy of its parameters.
    """
    wald, at_bound = significance(candidate.solution)
    left = omnibus(study, candidate.solution)
    return Trial(candidate=candidate, left=left, worth=wald, at_bound=at_bound, nominal_excess=nominal_excess)


@dataclass(slots=True)
class Searcher:
    """The tools of one search, with its running count of simulations.

    Parameters
    ----------
    study
        Study at the inner step of its readings.
    entries
        Catalogue effects by key, in SI units.
    found
        Their signatures at the nominal model.
    tests
        Number of independent tests of the catalogue.
    tell
        Told of each step.
    simulations
        Number of runs simulated in fits so far.
    finished
        Trials that were fitted to the end, by the keys of their effects.
    extended
        Keys of the effects on top of which the whole catalogue, and not only its few best scores, has been tried.
    cut
        Whether combinations of effects were left out because the effort was spent.
    nominal_excess
        Excess of the nominal model over the stated noise, as `Prediction.excess` [1].
    """

    study: Study
    entries: dict[str, Effect]
    found: Signatures
    tests: float
    tell: Progress
    simulations: int = 0
    finished: dict[frozenset[str], list[Trial]] = field(default_factory=dict)
    extended: set[frozenset[str]] = field(default_factory=set)
    cut: bool = False
    nominal_excess: float = 0.0

    def is_over(self) -> bool:
        """Say whether the effort of the study is spent; if so, record that combinations are left out.

        Returns
        -------
        bool
            True where as many runs as ``study.effort`` have been simulated.
        """
        if self.simulations < self.study.effort:
            return False
        if not self.cut:
            self.tell("no further combinations", figures=f"{self.simulations} runs simulated")
        self.cut = True
        return True

    def scan(self, solution: Solution) -> Scan:
        """Score the catalogue on the residual of ``solution``, with the signatures at the nominal model.

        Parameters
        ----------
        solution
            Optimum whose residual is scored.

        Returns
        -------
        Scan
            Best score of every effect, smallest p first.
        """
        return scan(self.study, solution, self.found, self.entries, tests=self.tests)

    def trial(self, candidate: Candidate, before: Candidate | None = None) -> Trial:
        """Judge a candidate.

        Parameters
        ----------
        candidate
            Refitted model.
        before
            Model that the candidate extends; its gains are over this model.

        Returns
        -------
        Trial
            Candidate with the tests for and against it.
        """
        self.simulations += candidate.calls * len(self.study.fitted)
        solution = candidate.solution
        judged = first_tests(self.study, candidate, self.nominal_excess)
        # The tests go from cheap to dear. Each is made only where those before it find nothing, since one finding is
        # enough; parameter constancy comes last because it fits all runs anew.
        if judged.passes:
            judged = replace(judged, left_p=self.scan(solution).family_p)
        if judged.adequate:
            judged = self.with_constancy(judged)
        return judged if before is None else judged.against(before)

    def with_constancy(self, judged: Trial) -> Trial:
        """Test whether the parameters of a model's effects are the same in all runs.

        Parameters
        ----------
        judged
            Trial without this test.

        Returns
        -------
        Trial
            The trial with `constant_p`; as it is without effects.
        """
        if not judged.solution.effects:
            return judged
        p, calls = constancy(self.study, judged.solution)
        self.simulations += calls
        return replace(judged, constant_p=p)

    def step(
        self,
        current: Candidate,
        begun: Sequence[Solution],
        most: int = THRESHOLDS.search.most_finished_if_none_adequate,
        *,
        freed: bool = False,
    ) -> list[Trial]:
        """Finish the best preliminary fits on top of ``current``.

        Parameters
        ----------
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
        ready = self.best_of_each(begun)
        while ready and len(trials) < THRESHOLDS.search.most_finished_fits:
            # Once one trial is adequate, only its rivals matter: fits that come near its likelihood. Until then the
            # number of fits is bounded, and more tightly where even the best are far from noise.
            if any(t.adequate for t in trials):
                ready = self._near_the_best(trials, ready)
            else:
                all_far = all(t.left.far for t in trials)
                if len(trials) >= (min(THRESHOLDS.search.most_finished_if_all_far, most) if all_far else most):
                    break
            if ready:
                best = ready.pop(0)
                if (made := self.find_finished(current, best)) is None:
                    self.look_ahead(ahead, [best, *(ready if trials else ())])
                    made = self.finish(current, best, ahead.pop(keys_of(best)))
                trials.append(made)
        trials = self.with_twins(current, trials)
        return trials if freed else self.with_best_freed(current, trials)

    def _near_the_best(self, trials: Sequence[Trial], ready: Sequence[Solution]) -> list[Solution]:
        """Keep preliminary fits that come near the best trial; a declared rival may be further from its optimum."""
        best = max(trials, key=lambda t: t.solution.log_likelihood).solution
        alike = self.rivals(best.effects[-1].key) if best.effects else set()
        near = best.log_likelihood - THRESHOLDS.search.rival_log_likelihood_gap
        far = best.log_likelihood - THRESHOLDS.search.declared_rival_log_likelihood_gap
        return [s for s in ready if s.log_likelihood > (far if s.effects[-1].id in alike else near)]

    def with_twins(self, current: Candidate, trials: list[Trial]) -> list[Trial]:
        """Add trials with the same equations as an adequate one, started at its optimum: neither of them is better.

        Parameters
        ----------
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
            for effects, ids in self.twins(solution.effects):
                if (keys := frozenset(e.key for e in effects)) in known:
                    continue
                known.add(keys)
                values = solution.values | {new: solution.values[old] for old, new in ids.items()}
                begun = solve(
                    self.study,
                    effects,
                    solution.noise,
                    values,
                    x0=solution.x0,
                    iterations=THRESHOLDS.candidate.first_try_simulations,
                )
                self.simulations += begun.calls * len(self.study.fitted)
                found.append(self.finish(current, begun))
        return found

    def twins(self, effects: tuple[Effect, ...]) -> Iterator[tuple[tuple[Effect, ...], dict[str, str]]]:
        """Yield models with the same equations under the names of another catalogue effect.

        Parameters
        ----------
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
            for other in self.entries.values():
                if other.id not in ids and (names := match_parameters(effect, other)) is not None:
                    yield (*effects[:k], other, *effects[k + 1 :]), names

    def find_finished(self, current: Candidate, begun: Solution) -> Trial | None:
        """Return a finished trial with the same effects where a new start promises no better one.

        Parameters
        ----------
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
        before = self.finished.get(keys_of(begun), ())
        for trial in sorted(before, key=lambda t: t.candidate.criterion)[:1]:
            effects, values = trial.solution.effects, trial.solution.values
            rough = at_step(self.study, self.study.factory.coarse)
            # Likelihoods under different noise models cannot be compared, so the finished fit takes a few steps under
            # the noise, and at the inner step, of the new start.
            there = solve(
                rough,
                effects,
                begun.noise,
                values,
                x0=trial.solution.x0,
                iterations=THRESHOLDS.candidate.first_try_simulations,
            )
            self.simulations += there.calls * len(self.study.fitted)
            ahead = begun.log_likelihood - there.log_likelihood
            lead = THRESHOLDS.search.least_lead_of_restart_over_excess * (trial.left.energy - trial.left.dof)
            if ahead < max(THRESHOLDS.candidate.least_gain_in_criterion / 2, lead):
                return trial.against(current)
        return None

    def best_of_each(self, *begun: Sequence[Solution]) -> list[Solution]:
        """Keep the best preliminary fit of every last effect.

        Parameters
        ----------
        *begun
            Preliminary fits, each with at least one effect.

        Returns
        -------
        list of Solution
            One for each key of a last effect, best first by `rank`.
        """
        first: dict[str, Solution] = {}
        for found in sorted((s for each in begun for s in each), key=self.rank):
            first.setdefault(found.effects[-1].key, found)
        return list(first.values())

    def with_best_freed(self, current: Candidate, trials: list[Trial]) -> list[Trial]:
        """Add a fit of the best trial through homotopy from the first guesses, where it is near noise but not adequate.

        Parameters
        ----------
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
        if len(self.finished.get(keys_of(best.solution), ())) > 1:
            return trials
        own = {q.id: best.solution.values[q.id] for e in effects for q in e.parameters}
        freed, calls = through_homotopy(
            at_step(self.study, self.study.factory.coarse),
            effects,
            own,
            tolerance=THRESHOLDS.fit.rough_tolerance_chi2,
        )
        self.simulations += calls * len(self.study.fitted)
        better = np.isfinite(freed.log_likelihood) and self.find_finished(current, freed) is None
        return [*trials, self.finish(current, freed)] if better else trials

    def ready(self, solution: Solution, most: int | None = None) -> list[Solution]:
        """Begin single effects on top of a model, and continue the promising ones.

        Parameters
        ----------
        solution
            Model that the effects extend.
        most
            Number of best scores that are begun. Where None, all effects are begun on the nominal model, and
            `most_effects_begun_on_effect` on a model with effects; never more than ``study.most``. Where the residual
            is so small that it is linear in what is missing, none below `least_score_share_of_small_effects` of the
            best score.

        Returns
        -------
        list of Solution
            Preliminary fits at the coarse step, best first.
        """
        every = len(self.entries)
        most = most or (THRESHOLDS.search.most_effects_begun_on_effect if solution.effects else every)
        most = min(most, self.study.most or every)
        if most >= THRESHOLDS.search.most_effects_continued:
            self.extended.add(keys_of(solution))
        rough = self.side_by_side(self.study.factory.coarse)
        scored = self.beside(solution, self.scan(solution))
        most = min(most, self._in_question(solution, scored))
        # Effects that are easily mistaken for the best one are tried whatever their score, lest a rival be missed.
        likely = self.rivals(scored[0].key) if scored else set()
        fresh = {s.key: s for k, s in enumerate(scored) if k < most or self.entries[s.key].id in likely}
        tried = [self.entries[key] for key in fresh]
        begun = self.map_all("effects, first fits", partial(begin, rough, solution), tried, fresh.values())
        begun = self.rank_fits(begun)
        named = self.rivals(begun[0].effects[-1].key) if begun else set()
        count = THRESHOLDS.search.most_effects_continued
        promising = begun[:count] + [s for s in begun[count:] if s.effects[-1].id in named]
        scores = [fresh[s.effects[-1].key] for s in promising]
        done = self.map_all("the best effects", partial(continue_refit, rough, solution), promising, scores)
        self.simulations += (sum(s.calls for s in begun) + sum(calls for _, calls in done)) * len(self.study.fitted)
        return self.rank_fits(s for s, _ in done)

    def _in_question(self, solution: Solution, scored: Sequence[Score]) -> int:
        """Count the effects whose scores do not rule them out beside the best; all of them where much is missing."""
        if not scored or leaves_much(solution.chi2, self.study.rows):
            return len(scored)
        least = THRESHOLDS.search.least_score_share_of_small_effects * max(score.T for score in scored)
        return max(k + 1 for k, score in enumerate(scored) if least <= score.T)

    def rivals(self, key: str) -> set[str]:
        """Return the rivals of a catalogue effect.

        Parameters
        ----------
        key
            Key of the effect.

        Returns
        -------
        set of str
            Ids of the effects that this one names as rivals, and of those that name this one.
        """
        entry = self.entries[key]
        return {*entry.rivals, *(other.id for other in self.entries.values() if entry.id in other.rivals)}

    def beside(self, solution: Solution, scored: Scan) -> list[Score]:
        """Return the scores of effects that are not in ``solution`` in any variant, best first.

        Parameters
        ----------
        solution
            Optimum whose effects are left out, by id.
        scored
            Scores of the catalogue, smallest p first.

        Returns
        -------
        list of Score
            In the order of ``scored``.
        """
        return [s for s in scored.scores if self.entries[s.key].id not in solution.ids]

    def anew(self, scored: Scan, onto: Solution) -> list[Solution]:
        """Fit single effects together with the nominal model through homotopy from the first guesses.

        Parameters
        ----------
        scored
            Scores of the catalogue on the residual of ``onto``.
        onto
            Model that the effects extend; its effects begin at their fitted parameters.

        Returns
        -------
        list of Solution
            Fits of the remaining effects, best first.

        Notes
        -----
        A nominal model that took a large effect upon itself may lie so far from the joint that no fit from there finds
        back, and no score there is informative. Under the observer, which holds the simulation near the readings,
        effects are compared early, and ever fewer continue:

        1. Fit all of them at the step `signature_step_s` under `sieve_gains` gains, shapes held by weak priors.
        2. Fit the best `most_effects_continued` of them at the coarse step under the next gains,
           `gains_until_distinguishable` in all.
        3. Release the observer for the best `most_effects_released` of them.

        Beside another effect, only the `most_effects_beside_effect` best scores are tried: while that effect is real,
        the missing one scores high.
        """
        self.extended.add(keys_of(onto))
        rough = self.side_by_side(self.study.factory.coarse)
        values = {q.id: q.initial for q in self.study.base.parameters}
        values |= {q.id: onto.values[q.id] for e in onto.effects for q in e.parameters}
        chosen: list[tuple[Effect, ...]] = []
        starts: list[dict[str, float]] = []
        most = THRESHOLDS.search.most_effects_beside_effect if onto.effects else self.study.most
        for score in self.beside(onto, scored)[:most]:
            effect = self.entries[score.key]
            for own in starts_of(effect, score):
                chosen.append((*onto.effects, effect))
                starts.append(values | own)
        sketch = partial(_sketch_fit, self.side_by_side(self.study.factory.sketch))
        begun = self.map_all("effects from first guesses", sketch, chosen, starts)
        few = best_first(begun)[: THRESHOLDS.search.most_effects_continued]
        sieved = self.map_all("the best from first guesses", partial(_sieve_fit, rough), few)
        fewer = best_first(sieved)[: THRESHOLDS.search.most_effects_released]
        calls = sum(low.reached.calls for _, low in (*begun, *sieved))
        self.simulations += calls * len(self.study.fitted)
        return self.release(rough, fewer)

    def release(self, rough: Study, tried: Sequence[Tried]) -> list[Solution]:
        """Release the observer for fits that it guided.

        Parameters
        ----------
        rough
            Study at the inner step of the fits, with one thread for each.
        tried
            Effects of models, each with its fit under the observer.

        Returns
        -------
        list of Solution
            Free fits, best first by `rank`.
        """
        done = self.map_all("the best of them, released", partial(_release_fit, rough), tried)
        self.simulations += sum(calls for _, calls in done) * len(self.study.fitted)
        return self.rank_fits(solution for solution, _ in done)

    def side_by_side(self, step: float) -> Study:
        """Return the study at an inner step [s], with one thread for each fit, for fits that run side by side.

        Parameters
        ----------
        step
            Inner step [s].

        Returns
        -------
        Study
            Copy of the study.
        """
        return replace(at_step(self.study, step), threads=1)

    def map_all(self, what: str, function: Callable[..., T], *arguments: Iterable[Any]) -> list[T]:
        """Apply ``function`` to every tuple of arguments, side by side on the study's threads.

        Parameters
        ----------
        what
            What is being done, for those who wait.
        function
            Function that releases the interpreter's lock; others gain nothing.
        *arguments
            Iterables of one length, one for each argument.

        Returns
        -------
        list
            Results in the order of the arguments.

        Raises
        ------
        ValueError
            Where the iterables differ in length.
        """
        tuples = list(zip(*arguments, strict=True))

        def count(done: int) -> None:
            self.tell(what, done, len(tuples), f"{self.simulations} runs simulated so far")

        if tuples:
            count(0)
        return map_threads(lambda each: function(*each), tuples, threads=self.study.threads, count=count)

    def rank_fits(self, fits: Iterable[Solution]) -> list[Solution]:
        """Return the finite fits, best first.

        Parameters
        ----------
        fits
            Optima of the same runs.

        Returns
        -------
        list of Solution
            By rising `rank`; fits whose log likelihood is not finite are left out.
        """
        return sorted((s for s in fits if np.isfinite(s.log_likelihood)), key=self.rank)

    def rank(self, solution: Solution) -> float:
        """Return the BIC of a fit up to a constant: smaller is better.

        Parameters
        ----------
        solution
            Optimum on the runs of the study.

        Returns
        -------
        float
            k·ln n − 2·ln L with k free parameters of effects and n rows.
        """
        return effect_parameters(solution) * float(np.log(self.study.rows)) - 2.0 * solution.log_likelihood

    def look_ahead(self, ahead: dict[frozenset[str], Candidate], ready: Sequence[Solution]) -> None:
        """Fit the first of ``ready`` to the end unless this was done, and the likely next ones side by side with it.

        Parameters
        ----------
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
            fresh = [ready[0], *(s for s in ready[1:] if keys_of(s) not in self.finished)][: self.study.threads]
            done = self.each(lambda study, s: settle(study, s.effects, s), fresh)
            ahead.update(zip(map(keys_of, fresh), done, strict=True))

    def each(self, function: Callable[[Study, S], T], chosen: Sequence[S]) -> list[T]:
        """Apply ``function`` to the study and each of ``chosen``; several run side by side on one thread each.

        Parameters
        ----------
        function
            Function of a study and one element.
        chosen
            Elements, as sets of effects; a single one has all threads of the study.

        Returns
        -------
        list
            Results in the order of ``chosen``.
        """
        study = self.study if len(chosen) == 1 else replace(self.study, threads=1)
        return self.map_all("fits to the end", partial(function, study), chosen)

    def finish(self, current: Candidate, begun: Solution, fitted: Candidate | None = None) -> Trial:
        """Fit a preliminary fit to the end, and judge it.

        Parameters
        ----------
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
        made = self.trial(fitted or settle(self.study, begun.effects, begun), current)
        made = self.on_its_path(made, current)
        self.finished.setdefault(keys_of(begun), []).append(made)
        noise = f"{plain(float(np.sqrt(made.left.energy / made.left.dof)))} times the noise is left"
        self.tell("judged " + "+".join(made.solution.keys), figures=noise)
        return made

    def on_its_path(self, made: Trial, before: Candidate | None = None) -> Trial:
        """Move the scatter to the other path where that alone makes the trial adequate.

        Parameters
        ----------
        made
            Judged trial.
        before
            Model that the trial extends.

        Returns
        -------
        Trial
            The trial with the scatter on the other path if that one is adequate, or else the given trial.

        Notes
        -----
        Both paths have to be fitted to compare them: a scatter on the torque is linear in the reading only about its
        own most probable amplitudes.
        """
        scatters = made.solution.noise.scatters
        if made.adequate or not scatters or made.left.far:
            return made
        other: Path = "torque" if scatters[0].path == "reading" else "reading"
        turned = self.trial(settle(self.study, made.solution.effects, made.solution, paths=(other,)), before)
        return turned if turned.adequate else made


def _sketch_fit(study: Study, effects: tuple[Effect, ...], values: Mapping[str, float]) -> Tried:
    """Fit briefly under the highest gains; a weak prior holds the shape of the last effect."""
    near = start_holding_last_shape(study, effects, values).down_to(
        THRESHOLDS.search.sieve_gains,
        THRESHOLDS.search.sieve_simulations_per_gain,
        THRESHOLDS.search.sieve_tolerance_chi2,
    )
    return effects, near


def _sieve_fit(study: Study, tried: Tried) -> Tried:
    """Continue at the inner step of ``study``, down to the gain at which effects are distinguishable."""
    effects, low = tried
    return effects, at_fine(study, effects, low).down_to(THRESHOLDS.search.gains_until_distinguishable)


def _release_fit(study: Study, tried: Tried) -> tuple[Solution, int]:
    """Release the observer and fit to the tolerance `rough_tolerance_chi2`."""
    return release_observer(study, *tried, THRESHOLDS.fit.rough_tolerance_chi2)


def best_first(found: Sequence[Tried]) -> list[Tried]:
    """Return the guided fit of least cost for every last effect, least cost first.

    Parameters
    ----------
    found
        Effects of models, each with its fit under the observer.

    Returns
    -------
    list of tuple
        One pair for every key of a last effect.
    """
    # Sorted by falling cost, the last fit of each effect that enters the dict is its cheapest.
    best = {both[-1].key: (both, low) for both, low in sorted(found, key=lambda pair: -pair[1].reached.cost)}
    return sorted(best.values(), key=lambda pair: pair[1].reached.cost)


def leaves_much(chi2: float, rows: int) -> bool:
    """Say whether a model leaves so much that its residual is no longer linear in what is missing.

    Parameters
    ----------
    chi2
        ‖r‖² over the stated noise.
    rows
        Number of scored residuals.

    Returns
    -------
    bool
        True beyond `least_energy_for_observer` a row.
    """
    return chi2 > THRESHOLDS.search.least_energy_for_observer * rows


def effect_parameters(solution: Solution) -> int:
    """Count the free parameters of the effects of a solution.

    Parameters
    ----------
    solution
        Optimum of a model with any number of effects.

    Returns
    -------
    int
        0 for the nominal model; fixed parameters do not count.
    """
    return sum(not q.fixed for e in solution.effects for q in e.parameters)
