"""Widen the range of the stiffness in presliding beside the best model: best `Trial` in, the same in a wider range out.

That range is a guess from the travel where neither user nor device states it. The nominal model may end within it, and
the model with the missing effects upon its end: what it then leaves is a discrepancy that is none of the joint's.
"""

from __future__ import annotations

from dataclasses import replace

from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.fit.nominal_fit import stiffer_study
from haptid.discrepancy.search.step_refinement import Refined, fit_again
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION


def in_wider_range(s: Searcher, best: Trial) -> Refined | None:
    """Refit the best model with stiffer presliding as long as it ends on the range and gains beyond.

    Parameters
    ----------
    s
        Tools of the search.
    best
        Best trial.

    Returns
    -------
    Refined or None
        The trial in the wider range, with the tools of the search there; None where it does not end on its range, or
        gains nothing beyond.
    """
    if not best.solution.effects:
        return None
    found: Refined | None = None
    least = THRESHOLDS.candidate.least_gain_in_criterion
    for _ in range(IDENTIFICATION.most_widenings_of_bounds):
        study = stiffer_study(s.study, best.solution)
        if study is None:
            break
        s = replace(s, study=study, finished={})
        again = fit_again(s, best)
        if not again.acceptable or best.candidate.criterion - again.candidate.criterion < least:
            break
        found, best = Refined(searcher=s, trials=(again,)), again
    return found
