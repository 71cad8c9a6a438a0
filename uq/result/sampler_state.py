"""What chains are worth, in one word: `Chains` in, `SamplerState` out.

Terminal, page and files say the same word; what it means and what to do stands in `report/common/words.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from haptid.uq.result.summary import ParameterSummary
from haptid.uq.sampling.sampling import Sample
from haptid.uq.thresholds import THRESHOLDS

SamplerState = Literal["sound", "short", "too_short", "ensembles_disagree"]

SENTENCES: dict[SamplerState, str] = {
    "sound": "",
    "short": "the chains are short, so that ends of intervals may move by a few percent",
    "too_short": "the chains are too short to agree; do not use the intervals yet: below is what they hold so far",
    "ensembles_disagree": "independent ensembles found different posteriors; do not use the intervals that follow",
}
"""What the terminal says at the head of a joint; nothing where all is well."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chains:
    """The chains of a posterior, with what they tell of each coordinate.

    Parameters
    ----------
    sample
        Chains of the coordinates η.
    parameters
        One summary per coordinate.
    modes
        Number of groups that the ensembles form; 1 where all sample the same mode.
    """

    sample: Sample
    parameters: tuple[ParameterSummary, ...]
    modes: int

    @property
    def worst_rhat(self) -> float:
        """Largest R̂ of a coordinate [1]."""
        return max(p.diagnostics.rhat for p in self.parameters)

    @property
    def state(self) -> SamplerState:
        """What the chains are worth."""
        return state_of(self.sample, self.worst_rhat, self.modes)

    @property
    def sound(self) -> bool:
        """Whether the ensembles agree and their autocorrelation time is known."""
        return self.state == "sound"


def state_of(sample: Sample, worst_rhat: float, modes: int) -> SamplerState:
    """Judge the chains of a posterior.

    Parameters
    ----------
    sample
        Chains.
    worst_rhat
        Largest R̂ of a coordinate [1].
    modes
        Number of groups that the ensembles form.

    Returns
    -------
    SamplerState
        ``ensembles_disagree`` where they found several modes, or one mode with long chains whose R̂ is large: a large
        R̂ of chains that are shorter than their autocorrelation asks for is what short chains have.
    """
    agree = worst_rhat < THRESHOLDS.least_rhat_of_disagreement
    if modes > 1:
        return "ensembles_disagree"
    if not sample.reached:
        return "short" if agree else "too_short"
    return "sound" if agree else "ensembles_disagree"


def tell_state(state: SamplerState) -> list[str]:
    """Tell the state of the chains as the line at the head of a joint.

    Parameters
    ----------
    state
        State of the chains.

    Returns
    -------
    list of str
        A line that begins with the word, as pages write it; none where the chains are sound.
    """
    return [f"  {state.replace('_', ' ')}: {SENTENCES[state]}"] if SENTENCES[state] else []
