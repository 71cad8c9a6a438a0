"""Search for missing effects in a joint whose torque is scored: `TorqueStudy` in, `TorqueSearch` out.

1. Fit the nominal model, and take out what friction differs by from run to run (`torque.run_friction`).
2. Scan the catalogue, and refit the most promising effects.
3. Add the best effect that fits and predicts better, and is no lag that takes the inertia's place (`rigid_body`);
   settle weights and restraints that the larger model asks for (`torque.fit.settle`); repeat from step 2 until none
   does, or the model leaves no more than the torque's noise.
4. Leave out what does not keep its place beside the others (`eliminate`).
5. Exchange each named effect for those that gained beside it, and keep what the runs cannot tell apart (`find_rivals`).

Under position control the residual is far above the torque's noise and correlated over many rows. So models are
compared by the energy of their residuals in stretches of several correlation lengths (`torque_search.stretches`).
An autoregression estimated from the residual of the model under suspicion would filter out whatever is slow.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from haptid.discrepancy.resonance.resonances import find_resonances, offered
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit, fit_model, fit_nominal, settle
from haptid.discrepancy.torque.readable import delays_torque
from haptid.discrepancy.torque.run_friction import even_out_friction
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.discrepancy.torque_search.candidate import TorqueCandidate, compare_candidates
from haptid.discrepancy.torque_search.certain import compute_stability, find_doubted
from haptid.discrepancy.torque_search.rigid_body import find_movers, moves_inertia
from haptid.discrepancy.torque_search.ripple import with_ripple
from haptid.discrepancy.torque_search.rivals import Rival, find_rivals
from haptid.discrepancy.torque_search.scan import Promise, promises
from haptid.model.effects.effect import Effect, id_of
from haptid.support.errors import NumericalError
from haptid.support.linear_algebra import rms
from haptid.support.listener import Progress
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueStep:
    """One round of the search.

    Parameters
    ----------
    promises
        All effects of the scan, best first.
    candidates
        Refitted models, best first.
    taken
        Candidate that was added, or None.
    """

    promises: tuple[Promise, ...]
    candidates: tuple[TorqueCandidate, ...]
    taken: TorqueCandidate | None


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueSearch:
    """Result of the search.

    Parameters
    ----------
    study
        Study of the joint.
    base
        Nominal model.
    final
        Model with all effects that were added.
    steps
        Rounds of the search.
    stability
        Share of bags [1] in which an effect of the final model keeps its name, by its key: what elimination judged by.
    rivals
        Effects that the runs cannot tell from a named one.
    """

    study: TorqueStudy
    base: TorqueFit
    final: TorqueFit
    steps: tuple[TorqueStep, ...]
    stability: Mapping[str, float]
    rivals: tuple[Rival, ...] = ()

    @property
    def simulations(self) -> int:
        """Number of simulated runs, those of the signatures included."""
        models = [self.base, *(c.model for step in self.steps for c in step.candidates)]
        signatures = sum(p.columns for step in self.steps for p in step.promises)
        return len(self.study.runs) * (sum(m.calls for m in models) + signatures)


def search_torque(
    study: TorqueStudy, catalogue: Mapping[str, Effect], *, starts: int, seed: int, tell: Progress
) -> TorqueSearch:
    """Add catalogue effects one by one while they gain.

    Parameters
    ----------
    study
        Study of the joint.
    catalogue
        Catalogue effects by key, in multiples of the joint's scales.
    starts
        Number of starts of the nominal fit.
    seed
        Seed of the starts and of the bags.
    tell
        Told of each step.

    Returns
    -------
    TorqueSearch
        Nominal and final model with the rounds between.

    Raises
    ------
    NumericalError
        If no start of a fit gives a finite torque.
    """
    tell("nominal fit")
    base = fit_nominal(study, starts=starts, seed=seed)
    if (evened := even_out_friction(base)) is not None:
        tell("friction of each run")
        base = evened
    study = base.study
    scales = study.scales(base.values)
    known = {key: effect.at(scales) for key, effect in catalogue.items()}
    resonances = _find_resonances(study, known)
    known = offered(known, resonances)
    current, steps = base, []
    for _ in range(THRESHOLDS.torque.most_effects):
        # Below the noise a name would stand for how the torque was sampled: many rows make next to nothing significant.
        if current.leaves_noise:
            break
        step = _step(study, base, current, known, resonances, tell)
        steps.append(step)
        if step.taken is None:
            break
        taken = step.taken.model
        current = settle(fit_model(study, taken.effects, taken.values))
        if current.study is not study:
            study = current.study
            base = fit_model(study, start=base.values)
    tell("backward elimination")
    final, stability = eliminate(study, current, base, seed=seed)
    # Without effects it is the nominal model, from a start that may end higher.
    final = final if final.effects else base
    tell("rivals")
    rivals = find_rivals(study, final, [(step.taken, step.candidates) for step in steps if step.taken is not None])
    return TorqueSearch(study=study, base=base, final=final, steps=tuple(steps), stability=stability, rivals=rivals)


def eliminate(
    study: TorqueStudy, model: TorqueFit, base: TorqueFit, *, seed: int = 0
) -> tuple[TorqueFit, dict[str, float]]:
    """Leave out effects that do not keep their place beside the others, the weakest first.

    An early effect may have stood for several that came later. A doubted name has to earn its place as an added one
    does: the simplest model is preferred where predictions lose nothing clear. A model that gains in most stretches and
    still leaves more of the held-out torque in all than the nominal one explains nothing.

    Parameters
    ----------
    study
        Study of the joint.
    model
        Model with all effects that were added.
    base
        Nominal model, whose inertia no effect may move far.
    seed
        Seed of the bags by which names are doubted.

    Returns
    -------
    model : TorqueFit
        Model whose every effect `TorqueCandidate.stays`, the doubted ones because the model predicts clearly better.
    stability : dict
        Share of bags [1] in which each of its effects keeps its name, by key.
    """
    while model.effects:
        stability = compute_stability(model, seed=seed)
        doubted = find_doubted(model, stability) | find_movers(base, model)
        worse = rms(model.unseen_away) >= rms(base.unseen_away)
        trials = []
        for effect in model.effects:
            rest = tuple(e for e in model.effects if e is not effect)
            trials.append(compare_candidates(effect.key, fit_model(study, rest, model.values), model))
        leaving = [t for t in trials if worse or not t.stays or (t.key in doubted and not t.predicts_better)]
        if not leaving:
            return model, stability
        weakest = min(leaving, key=lambda trial: trial.significance).key
        model = fit_model(study, tuple(e for e in model.effects if e.key != weakest), model.values)
    return model, {}


def _find_resonances(study: TorqueStudy, catalogue: Mapping[str, Effect]) -> dict[str, dict[str, float]]:
    """Return start values by the key of each effect whose resonance the fitted runs show; of a drive they are none."""
    fitted = [run for run in study.recorded if run.use == "fit"]
    if study.drive is not None or not fitted:
        return {}
    return find_resonances(fitted, catalogue, prismatic=study.prismatic)


def _step(
    study: TorqueStudy,
    base: TorqueFit,
    current: TorqueFit,
    catalogue: Mapping[str, Effect],
    resonances: Mapping[str, Mapping[str, float]],
    tell: Progress,
) -> TorqueStep:
    ids, keys = {e.id for e in current.effects}, {e.key for e in current.effects}
    free = {key: e for key, e in catalogue.items() if e.again == (e.id in ids) and key not in keys}
    every = with_ripple(current, free)
    found = promises(study, current, every, lambda done: tell("scan of the catalogue", done, len(every)))
    best = _choose_refits(found)
    models = map_threads(
        lambda promise: refit_candidate(
            study, current, promise, base=base, resonance=resonances.get(promise.effect.key, {})
        ),
        best, threads=study.threads, count=lambda done: tell("refits with an effect", done, len(best)),
    )  # fmt: skip
    candidates = []
    for promise, model in zip(best, models, strict=True):
        if model is not None:
            candidate = compare_candidates(promise.effect.key, current, model)
            takes_inertia = delays_torque(promise.effect) and moves_inertia(base, model)
            candidates.append(replace(candidate, stands_for_inertia=takes_inertia))
    ranked = tuple(sorted(candidates, key=lambda c: -(c.bic + c.evidence)))
    winner = next((c for c in ranked if c.acceptable), None)
    return TorqueStep(promises=tuple(found), candidates=ranked, taken=winner and _simplest_form(winner, ranked))


def _simplest_form(winner: TorqueCandidate, ranked: Sequence[TorqueCandidate]) -> TorqueCandidate:
    """Return the form of the winning effect with the fewest parameters over which the winner gains nothing.

    Gains over the model before are counted in correlation lengths of each form's own residual, so that they do not
    compare two forms; a family of harmonics has to gain over the single wave itself. A form that elimination would
    leave out again at once is none that the effect can have.
    """
    id, size = id_of(winner.key), winner.model.problem.n_parameters
    smaller = [c for c in ranked if id_of(c.key) == id and c.model.problem.n_parameters < size]
    for form in sorted(smaller, key=lambda c: c.model.problem.n_parameters):
        keeps_place = form.acceptable and form.stays
        if keeps_place and not compare_candidates(winner.key, form.model, winner.model).acceptable:
            return form
    return winner


def _choose_refits(found: Sequence[Promise]) -> list[Promise]:
    """Return the promises that are refitted: those of the best effects, and the best of those that delay the torque.

    Forms of one effect promise much the same, and two effects of four forms would take every place. Of each effect the
    best form is refitted, and the one with the fewest parameters, which may do as well (`_simplest_form`).
    A delay moves every fast part of a torque and promises a little of any residual: it takes no other effect's place.
    """
    late = [promise for promise in found if delays_torque(promise.effect)]
    forms: dict[str, list[Promise]] = {}
    for promise in found:
        if not delays_torque(promise.effect):
            forms.setdefault(promise.effect.id, []).append(promise)
    chosen = []
    for some in list(forms.values())[: THRESHOLDS.torque.most_refits_of_scan]:
        smallest = min(some, key=lambda promise: len(promise.effect.parameters))
        smaller = len(smallest.effect.parameters) < len(some[0].effect.parameters)
        chosen += [some[0], smallest] if smaller else [some[0]]
    return [*chosen, *late[:1]]


def refit_candidate(
    study: TorqueStudy,
    current: TorqueFit,
    promise: Promise,
    *,
    base: TorqueFit | None = None,
    resonance: Mapping[str, float] | None = None,
) -> TorqueFit | None:
    """Refit everything with one effect more, from several starts.

    Parameters
    ----------
    study
        Study of the joint.
    current
        Model that the effect extends.
    promise
        Effect with its start values.
    base
        Nominal model; ``current`` where None.
    resonance
        Start values by id that the frequency response gives the effect; none where None.

    Returns
    -------
    TorqueFit or None
        The fit with the smallest residual on fitted rows; None where no start gives a finite torque. Of a delay, a fit
        that leaves the inertia of the nominal model near goes before one that does not.
    """
    fits: list[TorqueFit] = []

    def fit_from(start: dict[str, float]) -> None:
        effects, enough = (*current.effects, promise.effect), THRESHOLDS.torque.least_decrease_of_trial
        with suppress(NumericalError):
            fits.append(fit_model(study, effects, start, relative=enough))

    fit_from(current.values | _scale_amplitudes(promise, 1.0))
    if not (fits and _keeps_promise(fits[0], promise, current)):
        # A linear estimate may be far too large; a tenth of its amplitudes is the second start.
        fit_from(current.values | _scale_amplitudes(promise, 0.1))
    if promise.effect.side == "friction":
        # Friction that lacks the effect may have fled to where no descent comes back from, such as bristles as long as
        # the travel.
        fit_from(current.values | study.guessed_friction | _scale_amplitudes(promise, 1.0))
    if resonance:
        fit_from(current.values | promise.start | dict(resonance))
    if not fits:
        return None
    # A lag and the joint's own time constant may change places and leave much the same.
    delays, nominal = delays_torque(promise.effect), current if base is None else base
    return min(fits, key=lambda f: (delays and moves_inertia(nominal, f), rms(f.fitted)))


def _keeps_promise(refit: TorqueFit, promise: Promise, current: TorqueFit) -> bool:
    """Whether a refit takes most of the energy off the fitted rows that the scan promised."""
    taken = 1.0 - (rms(refit.fitted) / rms(current.fitted)) ** 2
    return bool(taken >= THRESHOLDS.torque.least_kept_share_of_promise * promise.share)


def _scale_amplitudes(promise: Promise, share: float) -> dict[str, float]:
    """Return the start values of a promise with a share of its amplitudes."""
    return {id: value * (share if id in promise.effect.neutral else 1.0) for id, value in promise.start.items()}
