"""Search for large effects under the observer: `Searcher` and nominal `Solution` in, leading fits out.

Far from the truth a free simulation is bent in every parameter, and two effects hide each other. Under an observer that
holds the simulation near the readings, the residual is nearly linear in effects of any size: what an effect has missed
is forgotten after 1/L. So the catalogue can be scored there by linear least squares, and effects chosen one by one.

1. Fit the nominal model under falling gains, down to the one at which effects are distinguishable, or to the next where
   the observer hides what is missing, and simulate the signatures of the catalogue there (`begin_under_observer`).
2. Score the catalogue on the residual, begin refits of the effects of the best scores under that gain with everything
   else, and finish the most promising. Take the best one, leave out what has become unnecessary, put harmonics in the
   place of a wave that they improve, and repeat until no effect takes a share of the residual (`follow_leads`).
3. Release the observer (`release_leads`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace

from haptid.discrepancy.candidate.starts import start_values
from haptid.discrepancy.detect.score_tests import Score, scan
from haptid.discrepancy.detect.signatures import Signatures, scored_alone, signatures
from haptid.discrepancy.fit.homotopy import Guided, start_holding_last_shape
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.search.trials.preliminary_fits import release_fits
from haptid.discrepancy.search.trials.searcher import Searcher, leaves_much
from haptid.discrepancy.study.simulators import Factory
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect


@dataclass(frozen=True, slots=True, kw_only=True)
class Lead:
    """A model that was fitted under the observer.

    Parameters
    ----------
    effects
        Its effects in SI units.
    fit
        Its fit under the gain under which models are compared.
    """

    effects: tuple[Effect, ...]
    fit: Guided

    @property
    def cost(self) -> float:
        """‖r‖² under the observer, in squares over the noise."""
        return self.fit.reached.cost

    @property
    def name(self) -> str:
        """Keys of the effects."""
        return "+".join(e.key for e in self.effects)

    def over_noise(self, rows: int) -> float:
        """Return the root mean square of the residual over the noise.

        Parameters
        ----------
        rows
            Number of scored residuals.

        Returns
        -------
        float
        """
        return float(self.cost / rows) ** 0.5

    def is_far(self, rows: int) -> bool:
        """Say whether more than noise is left, whose stated size may be off.

        Parameters
        ----------
        rows
            Number of scored residuals.

        Returns
        -------
        bool
        """
        return self.over_noise(rows) > THRESHOLDS.search.largest_left_of_noise_under_observer

    def excess(self, rows: int) -> float:
        """Return ‖r‖² beyond what noise alone leaves in ``rows`` residuals.

        Parameters
        ----------
        rows
            Number of scored residuals.

        Returns
        -------
        float
            At least 0.
        """
        return max(self.cost - rows, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class UnderObserver:
    """What is searched under the observer in one study.

    Parameters
    ----------
    study
        Study at the coarse inner step.
    start
        Nominal model.
    found
        Signatures of the catalogue there. They serve beside effects too: the simulation stays near the readings,
        whatever the model.
    excess
        ‖r‖² beyond noise that the nominal model leaves there under the friction law that was asked for.
    hidden
        Keys of effects that the nominal model takes upon itself but for `largest_share_of_hidden_signature`: what is
        left of a signature is then mostly its own error, so that no score passes over them.
    """

    study: Study
    start: Lead
    found: Signatures
    excess: float
    hidden: frozenset[str]

    @property
    def gains(self) -> int:
        """Number of gains of the homotopy that every fit passes here."""
        return self.start.fit.level


def begin_under_observer(s: Searcher, nominal: Solution) -> UnderObserver:
    """Fit the nominal model under the observer, and simulate the signatures of the catalogue there.

    Parameters
    ----------
    s
        Tools of the search.
    nominal
        Fit of the nominal model, where the fit begins.

    Returns
    -------
    UnderObserver
    """
    study = s.side_by_side(s.study.factory.coarse)
    start = fit_lead(s, study, (), nominal.values, THRESHOLDS.search.gains_until_distinguishable)
    if not leaves_much(start.cost, study.rows):  # it pushes aside what acts slowly
        lower = start.fit.down_to(THRESHOLDS.search.gains_where_observer_hides)
        s.simulations += (lower.reached.calls - start.fit.reached.calls) * len(study.fitted)
        start = replace(start, fit=lower)
    found = signatures_about(s, study, start)
    scores = scan(study, start.fit.linearised(()), found, s.catalogue, tests=1.0).scores
    most = THRESHOLDS.search.largest_share_of_hidden_signature
    hidden = frozenset(score.key for score in scores if score.survives < most)
    return UnderObserver(study=study, start=start, found=found, excess=start.excess(study.rows), hidden=hidden)


def at_step_under_observer(at: UnderObserver) -> Study:
    """Choose the inner step whose error takes no share of what is missing under the observer.

    Parameters
    ----------
    at
        Study and nominal model, at any inner step.

    Returns
    -------
    Study
        At the longest step h, halved from that of ``at``, with ‖(y_h − y_{h/2})/σ‖² below
        `least_share_of_all_under_observer` of the excess: what is less is not searched on. Sensitivities have that step
        too, and signatures twice it.
    """
    fit, study = at.start.fit, at.study

    def residual(at_finer: Study) -> Array:
        problem = start_holding_last_shape(at_finer, at.start.effects, fit.values).problem
        return problem.blocks(fit.reached.x, fit.gain, jacobian=False).residual

    for _ in range(THRESHOLDS.detect.most_step_halvings):
        step = study.factory.step / 2
        finer = replace(study, factory=Factory(step, step / THRESHOLDS.study.coarse_step_s))
        error = residual(finer) - residual(study)
        if float(error @ error) < THRESHOLDS.search.least_share_of_all_under_observer * at.excess:
            break
        study = finer
    return study


def signatures_about(s: Searcher, study: Study, start: Lead) -> Signatures:
    """Simulate the signatures of the catalogue about a nominal model under the observer.

    Parameters
    ----------
    s
        Tools of the search.
    study
        Study at the coarse inner step, under the friction law of the model.
    start
        Nominal model.

    Returns
    -------
    Signatures
    """
    effects = scored_alone(s.catalogue)

    def count(done: int) -> None:
        s.tell("signatures under the observer", done, len(effects))

    share = THRESHOLDS.search.share_of_amplitude_under_observer
    found = signatures(study, start.fit.linearised(()), effects, count, gain=start.fit.gain, share=share)
    s.simulations += found.simulations
    return found


def follow_leads(
    s: Searcher,
    at: UnderObserver,
    before: Lead,
    made: Sequence[Lead] | None = None,
    is_enough: Callable[[Lead], bool] = lambda _: False,
) -> list[list[Lead]]:
    """Choose effects one by one under the observer.

    Parameters
    ----------
    s
        Tools of the search.
    at
        Study, nominal model and signatures.
    before
        Model that is extended.
    made
        What `extend_lead` returned for it, where it was extended once already.
    is_enough
        Asked after the first round where more than noise is left: whether no further effect is wanted.

    Returns
    -------
    list of list of Lead
        Models of every round, best first: the one that is extended, then those that come near it. No round where no
        effect takes a share of the residual.
    """
    rows, rounds = at.study.rows, list[list[Lead]]()
    while len(before.effects) < THRESHOLDS.search.most_effects_under_observer:
        if before.excess(rows) <= _least_gain(before, at):
            break
        made = extend_lead(s, at, before) if made is None else made
        if not made or not _takes_a_share(made[0], before, at):
            break
        now = _with_harmonics(s, at, _without_unneeded(s, at, made[0]))
        rounds.append([now, *(lead for lead in made[1:] if _comes_near(lead, made[0], rows))])
        first, before, made = not before.effects, now, None
        s.tell(f"{now.name} under the observer", figures=f"{now.over_noise(rows):.3g} times the noise is left")
        if first and now.is_far(rows) and is_enough(now):
            break
    return rounds


def _takes_a_share(now: Lead, before: Lead, at: UnderObserver) -> bool:
    """Say whether an effect takes enough of the excess before it, and of that of the nominal model."""
    return before.cost - now.cost > _least_gain(before, at)


def _least_gain(before: Lead, at: UnderObserver) -> float:
    return max(
        THRESHOLDS.search.least_share_under_observer * before.excess(at.study.rows),
        THRESHOLDS.search.least_share_of_all_under_observer * at.excess,
        THRESHOLDS.candidate.least_gain_in_criterion,
    )


def _comes_near(lead: Lead, best: Lead, rows: int) -> bool:
    near = THRESHOLDS.search.largest_excess_of_near_lead * best.excess(rows)
    return lead.excess(rows) <= max(near, best.excess(rows) + 2 * THRESHOLDS.search.rival_log_likelihood_gap)


def fit_lead(
    s: Searcher,
    study: Study,
    effects: tuple[Effect, ...],
    values: Mapping[str, float],
    gains: int,
    most: int = THRESHOLDS.fit.most_simulations_of_gain,
) -> Lead:
    """Fit a model under falling gains, to the one under which models are compared.

    Parameters
    ----------
    s
        Tools of the search.
    study
        Study at the coarse inner step.
    effects
        Effects in SI units.
    values
        Start values of parameters by id.
    gains
        Number of gains of the homotopy that are passed.
    most
        Largest number of simulations of all runs under one gain.

    Returns
    -------
    Lead
    """
    fit = start_holding_last_shape(study, effects, values).down_to(gains, most)
    s.simulations += fit.reached.calls * len(study.fitted)
    return Lead(effects=effects, fit=fit)


def extend_lead(s: Searcher, at: UnderObserver, before: Lead) -> list[Lead]:
    """Refit a model with each of the effects that score best on its residual under the observer.

    Parameters
    ----------
    s
        Tools of the search.
    at
        Study and signatures.
    before
        Model that is extended.

    Returns
    -------
    list of Lead
        Models with one effect more, best first.
    """
    about = before.fit.linearised(before.effects)
    scored = s.beside(about, scan(at.study, about, at.found, s.catalogue, tests=1.0))

    def begin(score: Score) -> Lead:
        effects = (*before.effects, s.catalogue[score.key])
        values = _near_start(s, at, before, effects, score)
        return fit_lead(s, at.study, effects, values, at.gains, THRESHOLDS.search.simulations_of_a_try_under_observer)

    def refit(begun: Lead) -> Lead:
        return fit_lead(s, at.study, begun.effects, begun.fit.values, at.gains)

    best, anyway = _best_scores(scored), set[str]()
    if not before.effects:
        # The signatures of resonances lie at the shapes of a grid, between which one is not seen.
        anyway = {*s.resonances, *at.hidden}
        chosen = {score.key for score in best}
        best += [score for score in scored if score.key in anyway - chosen]
    tried = s.map_all("effects under the observer, first tries", begin, best)
    made = s.map_all("effects under the observer", refit, list(_promising(s, tried, best, anyway)))
    return sorted(made, key=lambda lead: lead.cost)


def _near_start(
    s: Searcher, at: UnderObserver, before: Lead, effects: tuple[Effect, ...], score: Score
) -> Mapping[str, float]:
    """Return start values of a model with one effect more, from the shape and the size that leave least.

    The linear estimate of a large effect may be several times too large: a spring that bends the wrong way lets the
    simulation diverge, and a brief fit does not come back from there. Nor need the shape that scores best at small
    sizes be that of a large effect.
    """
    shapes = [(score.point, score.amplitude), *((point, amplitude) for point, _, amplitude in score.others)]
    starts = [
        before.fit.values | start_values(effects[-1], point, [share * factor for factor in amplitude])
        for point, amplitude in shapes
        for share in THRESHOLDS.search.shares_of_linear_amplitude
    ]
    if score.key in s.resonances and not before.effects:
        # A nominal model without the resonance has bent inertia and friction; the first guesses have not.
        guesses = {q.id: q.initial for q in s.study.base.parameters}
        own = start_values(effects[-1], score.point, score.amplitude) | dict(s.resonances[score.key])
        starts += [before.fit.values | own, guesses | own]
    costs = [start_holding_last_shape(at.study, effects, start).cost_under(at.start.fit.gain) for start in starts]
    s.simulations += len(starts) * len(at.study.fitted)
    return starts[costs.index(min(costs))]


def _without_unneeded(s: Searcher, at: UnderObserver, lead: Lead) -> Lead:
    """Leave out the effects that take no share beside the later ones: they stood in for them."""
    for effect in lead.effects[:-1]:
        others = tuple(e for e in lead.effects if e.id != effect.id)
        fewer = fit_lead(s, at.study, others, lead.fit.values, at.gains)
        if not _takes_a_share(lead, fewer, at):
            lead = fewer
    return lead


def _with_harmonics(s: Searcher, at: UnderObserver, lead: Lead) -> Lead:
    """Put a series of harmonics in the place of its wave, where the series takes a share of what the wave leaves."""
    for wave in lead.effects:
        for series in (e for e in s.catalogue.values() if e.series_of == wave.key):
            others = tuple(e for e in lead.effects if e.id != wave.id)
            own = {x.id for x in series.parameters}
            first = {x.id if x.id in own else f"{x.id}_1": lead.fit.values[x.id] for x in wave.parameters}
            wider = fit_lead(s, at.study, (*others, series), lead.fit.values | first, at.gains)
            if _takes_a_share(wider, lead, at):
                lead = wider
    return lead


def _best_scores(scored: Sequence[Score]) -> list[Score]:
    """Return the best scores, many of them: beside an effect the linear score may be far below what a refit takes."""
    by_T = sorted(scored, key=lambda score: -score.T)
    least = max((THRESHOLDS.search.least_score_share_under_observer * score.T for score in by_T), default=0.0)
    return [score for score in by_T if least <= score.T][: THRESHOLDS.search.most_tries_under_observer]


def _promising(s: Searcher, tried: Sequence[Lead], by_T: Sequence[Score], anyway: Set[str]) -> Iterator[Lead]:
    """Yield the best of the models that were begun, those of the best scores, of rivals of the best, and ``anyway``.

    A try may end before a large effect has found its size, so that a few of the best scores go on in any case.
    """
    by_cost = sorted(tried, key=lambda lead: lead.cost)
    rivals = s.rivals(by_cost[0].effects[-1].key) if by_cost else ()
    also = {score.key for score in by_T[: THRESHOLDS.search.most_scores_refitted_under_observer]}
    for k, lead in enumerate(by_cost):
        last = lead.effects[-1]
        asked = last.key in also or last.id in rivals or last.key in anyway
        if k < THRESHOLDS.search.most_refits_under_observer or asked:
            yield lead


def release_leads(s: Searcher, leads: Sequence[Lead]) -> list[Solution]:
    """Release the observer for models that were reached under it.

    Parameters
    ----------
    s
        Tools of the search.
    leads
        Models fitted under the observer.

    Returns
    -------
    list of Solution
        Free fits, best first by `Searcher.rank`.
    """
    return release_fits(s, s.side_by_side(s.study.factory.coarse), [(lead.effects, lead.fit) for lead in leads])
