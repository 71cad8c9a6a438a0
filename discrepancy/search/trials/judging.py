"""Judge candidates: `Searcher` and refitted `Candidate` in, `Trial` with the tests for and against it out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from haptid.discrepancy.candidate.candidate import Candidate, significance
from haptid.discrepancy.candidate.parameter_constancy import constancy
from haptid.discrepancy.candidate.refit import settle
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.omnibus import omnibus
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.study.study import Study
from haptid.noise.correlation import Path


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
    return Trial(candidate=candidate, left=left, least_evidence=wald, at_bound=at_bound, nominal_excess=nominal_excess)


def judge_candidate(s: Searcher, candidate: Candidate, before: Candidate | None = None) -> Trial:
    """Judge a candidate.

    Parameters
    ----------
    s
        Tools of the search.
    candidate
        Refitted model.
    before
        Model that the candidate extends; its gains are over this model.

    Returns
    -------
    Trial
        Candidate with the tests for and against it.
    """
    s.simulations += candidate.calls * len(s.study.fitted)
    solution = candidate.solution
    judged = first_tests(s.study, candidate, s.nominal_excess)
    # The tests go from cheap to dear. Each is made only where those before it find nothing, since one finding is
    # enough; parameter constancy comes last because it fits all runs anew.
    if judged.passes:
        judged = replace(judged, left_p=s.scan(solution).family_p)
    if judged.adequate:
        judged = judge_constancy(s, judged)
    return judged if before is None else judged.against(before)


def judge_constancy(s: Searcher, judged: Trial) -> Trial:
    """Test whether the parameters of a model's effects are the same in all runs.

    Parameters
    ----------
    s
        Tools of the search.
    judged
        Trial without this test.

    Returns
    -------
    Trial
        The trial with `constant_p`; as it is without effects.
    """
    if not judged.solution.effects:
        return judged
    p, id, calls = constancy(s.study, judged.solution)
    s.simulations += calls
    return replace(judged, constant_p=p, varying=id)


def judge_on_other_path(s: Searcher, made: Trial, before: Candidate | None = None) -> Trial:
    """Move the scatter to the other path where that alone makes the trial adequate.

    Parameters
    ----------
    s
        Tools of the search.
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
    turned = judge_candidate(s, settle(s.study, made.solution.effects, made.solution, paths=(other,)), before)
    return turned if turned.adequate else made


def explains_all(trials: Sequence[Trial]) -> bool:
    """Say whether a trial is both adequate and acceptable.

    Parameters
    ----------
    trials
        Judged candidates.

    Returns
    -------
    bool
        False without trials.
    """
    return any(t.adequate and t.acceptable for t in trials)


def all_far(trials: Sequence[Trial]) -> bool:
    """Say whether there are trials, and all of them are far from noise.

    Parameters
    ----------
    trials
        Judged candidates.

    Returns
    -------
    bool
        False without trials.
    """
    return bool(trials) and all(t.left.far for t in trials)
