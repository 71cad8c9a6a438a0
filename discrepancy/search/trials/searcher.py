"""Hold what one search knows and has spent: `Searcher` scores the catalogue, fits side by side, and ranks fits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.inner_step import at_step
from haptid.discrepancy.detect.score_tests import Scan, Score, scan
from haptid.discrepancy.detect.signatures import Signatures
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect
from haptid.support.listener import Progress
from haptid.support.processes.threads import map_threads

S = TypeVar("S")
T = TypeVar("T")


@dataclass(slots=True)
class Searcher:
    """The tools of one search, with its running count of simulations.

    Parameters
    ----------
    study
        Study at the inner step of its readings.
    catalogue
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
    resonances
        Start values from the frequency response, inertia among them, by the key of each effect whose resonance the runs
        show; empty where the nominal model is near.
    """

    study: Study
    catalogue: dict[str, Effect]
    found: Signatures
    tests: float
    tell: Progress
    simulations: int = 0
    finished: dict[frozenset[str], list[Trial]] = field(default_factory=dict)
    extended: set[frozenset[str]] = field(default_factory=set)
    cut: bool = False
    nominal_excess: float = 0.0
    resonances: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

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
        return scan(self.study, solution, self.found, self.catalogue, tests=self.tests)

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
        return [s for s in scored.scores if self.catalogue[s.key].id not in solution.ids]

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
        effect = self.catalogue[key]
        return {*effect.rivals, *(other.id for other in self.catalogue.values() if effect.id in other.rivals)}

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
