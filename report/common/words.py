"""The words in which results judge: each with what it means and what to do, for every page and for the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Level = Literal["good", "look", "bad", "plain"]
"""How a word reads: all is well; worth a look; do not use as it is; no judgement."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Word:
    """A word of judgement.

    Parameters
    ----------
    key
        ``group-word``, unique; the word is what files say.
    text
        What pages say.
    level
        Colour and sign.
    meaning
        What it means, a sentence.
    action
        What to do next, a sentence.
    plain
        The word in plain words, which the first screen shows beside it; empty where the word is one.
    """

    key: str
    text: str
    level: Level
    meaning: str
    action: str
    plain: str = ""


MORE_WORDS = (
    "All words in which results judge stand in the documentation under Reference, Words of judgement "
    "(docs/reference/outcomes.md in a clone); its how-to pages lead through what to do."
)
"""Where a reader goes on from the words of a page, which is read where no documentation may be."""
PLAIN_WORDS = {
    "fit-above_noise": "the model lacks something",
    "fit-single_start": "reached by one start alone, at the noise",
    "fit-lonely": "reached by one start alone, above the noise",
    "fit-unexplained": "the model explains hardly anything",
    "fit-unexcited": "the torque never changes",
    "fit-fixed": "nothing was fitted",
    "fit-unseen": "at the noise on the fitted runs, not on the others",
    "fit-torque_scored": "the torque was fitted, not the position",
    "fit-plain": "inertia, gravity and simple friction predict better than the whole model",
    "fit-observed": "the measured position corrects the simulation",
    "status-prior": "mostly what was put in",
    "status-unidentifiable": "not known from these runs alone",
    "status-at_bound": "stopped at the end of the range that it may take",
    "whole-as_noise": "noise alone is left",
    "whole-explained": "above the noise, by what the parameters leave open",
    "whole-uncertain": "the parameters leave too much open to tell",
    "whole-unexplained": "more is left than the parameters leave open",
    "verdict-partly_named": "a part is named, a part is left",
    "verdict-ambiguous": "several explanations fit alike",
    "verdict-unlisted": "no effect of the catalogue explains it",
}
"""Plain words beside what is jargon, by key."""


def _group(name: str, *words: tuple[str, Level, str, str]) -> tuple[Word, ...]:
    return tuple(
        Word(
            key=f"{name}-{word}",
            text=word.replace("_", " "),
            level=level,
            meaning=meaning,
            action=action,
            plain=PLAIN_WORDS.get(f"{name}-{word}", ""),
        )
        for word, level, meaning, action in words
    )


FITS = _group(
    "fit",
    (
        "converged", "good",
        "Several starts agree on the best minimum, and what is left is the sensor's noise. Where a run leaves somewhat "
        "more that is not white, the joint's section says so: haptid missing may name it.",
        "Use the values.",
    ),
    (
        "above_noise", "look",
        "Several starts agree on the best minimum, but more than the noise is left: the model lacks something.",
        "Run haptid missing on this joint.",
    ),
    (
        "single_start", "look",
        "One start alone reached the best minimum. It leaves the sensor's noise; whether it is the best is not sure.",
        "Raise --starts.",
    ),
    (
        "lonely", "bad",
        "One start alone reached the best minimum, and more is left than the sensor's noise.",
        "Raise --starts, then run haptid missing; where much of the motion is left, check columns and units first.",
    ),
    (
        "unexplained", "bad",
        "The model explains hardly anything of the motion. Columns, units or signs are often wrong.",
        "Check columns, units and signs with haptid check, then run haptid missing.",
    ),
    (
        "unexcited", "bad",
        "The torque never changes in the fitted runs, so that they do not tell how the joint answers to it.",
        "Look whether the torque was recorded, and in which column. Of a free swing fix a known inertia or gravity.",
    ),
    (
        "fixed", "plain",
        "Every parameter is fixed: nothing was fitted, and the scores are those of the model as it is stated.",
        "Free parameters under [joint.J.parameters] to fit them.",
    ),
    (
        "unseen", "look",
        "Fitted runs are at the sensor's noise, but runs that no fit saw are not.",
        "Compare columns and units of both kinds of runs, then run haptid missing on this joint.",
    ),
    (
        "too_few_rows", "bad",
        "The fitted runs hold too few rows for so many parameters, so that a small residual says nothing.",
        "Measure longer, or fix parameters under [joint.J.parameters].",
    ),
    (
        "torque_scored", "look",
        "The runs were made under position control, where a simulation from the torque drifts. The torque was fitted, "
        "with the measured motion as input.",
        "Use the values; run haptid missing where the residual is above the noise.",
    ),
    (
        "plain", "look",
        "The plain model (inertia, gravity, Coulomb and viscous friction, a constant torque) predicts runs that no fit "
        "saw better than a fit of the whole model, so that it is the result.",
        "Use the plain model with care: its values are uncertain. Try haptid missing; make runs at low speed, which "
        "excite friction.",
    ),
    (
        "observed", "look",
        "Small errors grow during these runs. The fit feeds the measured position back through an observer and is no "
        "free simulation.",
        "Use identified values, but none that is told as uncertain: try haptid missing on this joint. Expect a free "
        "simulation to drift.",
    ),
)  # fmt: skip
STATUSES = _group(
    "status",
    ("identified", "good", "The data determine the value, within the standard deviation beside it.", "Use it."),
    ("fixed", "plain", "The campaign or the device fixes the value; it was not fitted.", "Free it to fit it."),
    (
        "prior", "look",
        "The data did not halve the width of the prior: the value is mostly what was put in. Where none was stated, "
        "haptid holds stiction and Stribeck velocity near usual values.",
        "Make runs that excite it, or live with the prior.",
    ),
    (
        "unidentifiable", "look",
        "The value alone is not known, or only within 50 %. A combination with others may be known well.",
        "Use a combination where the page lists one, or make runs that tell them apart; of a device with several "
        "joints, haptid plan proposes them.",
    ),
    (
        "at_bound", "bad",
        "The best value lies at the end of its range, stated or chosen by haptid: the data want to go beyond.",
        "State a wider range under [joint.J.parameters] if physics allows, else look what the model lacks.",
    ),
)  # fmt: skip
UNFIT = _group(
    "unfit",
    (
        "uncertain", "look",
        "Parts of the motion agree on the value, but the model leaves more than the noise: what it lacks may have "
        "moved the value by far more than the standard deviation beside it.",
        "Do not take it for the machine's value: find what the model lacks (of a joint, haptid missing does).",
    ),
)  # fmt: skip
WHOLE = _group(
    "whole",
    (
        "as_noise", "good",
        "On runs with all joints free, the whole model leaves the sensor's noise on every joint.",
        "Use the FMU of the device.",
    ),
    (
        "explained", "good",
        "The whole model leaves more than the noise, but no more than the parameters' uncertainty explains.",
        "Run tests in the lock postures that haptid plan proposes, to narrow it.",
    ),
    (
        "uncertain", "look",
        "The whole model leaves more than the noise, and its parameters leave so much open that this says nothing: "
        "whatever it lacks would be hidden.",
        "Expect the FMU of the device to miss by as much; run tests in the lock postures that haptid plan proposes.",
    ),
    (
        "unexplained", "bad",
        "The whole model leaves more than noise and the parameters' uncertainty explain: something is missing in it.",
        "Run haptid missing with all joints.",
    ),
    (
        "diverged", "bad",
        "The simulation of the whole model did not stay finite.",
        "Simulate in closed loop: give the controller in the campaign.",
    ),
)  # fmt: skip
VERDICTS = _group(
    "verdict",
    (
        "nothing_missing", "good",
        "No effect of the catalogue, and no shape without a name, improves the model beyond chance.",
        "Use the model as it is.",
    ),
    (
        "named", "good",
        "The named effects explain what the model missed, and no other effect of the catalogue does as well.",
        "Use the rebuilt FMU; confirm with a run that no fit saw.",
    ),
    (
        "partly_named", "look",
        "The named effects explain a part; more is left than does not repeat.",
        "Use the rebuilt FMU, where there is one and what it leaves suffices; the page shows where the rest lies.",
    ),
    (
        "ambiguous", "look",
        "The runs cannot tell the listed alternatives apart.",
        "Make the run that the page proposes, and search again. Where no run would tell, either model serves: choose "
        "by what is known of the machine.",
    ),
    (
        "unlisted", "bad",
        "Something real is missing that no effect of the catalogue explains.",
        "Look at the shape on the page; add an effect of your own to the catalogue.",
    ),
)  # fmt: skip
SAMPLERS = _group(
    "sampler",
    ("sound", "good", "Independent ensembles agree, and the chains are long enough.", "Use the intervals."),
    (
        "short", "look",
        "The ensembles agree, but the chains are short: ends of intervals may move by a few percent.",
        "Where the ends matter, run without --quick; after a whole run, fix what the runs leave open.",
    ),
    (
        "too_short", "bad",
        "The chains are too short to tell whether the ensembles agree. They found one mode.",
        "Do not use these intervals yet: run without --quick; after a whole run, fix what the runs leave open.",
    ),
    (
        "ensembles_disagree", "bad",
        "Independent ensembles found different posteriors.",
        "Do not use these intervals: look for several modes in the corner plot, and bound the parameters to one.",
    ),
)  # fmt: skip
GROUPS: dict[str, tuple[Word, ...]] = {
    "How a fit ended": FITS,
    "Status of a parameter": STATUSES,
    "Value of a model that leaves more than the noise": UNFIT,
    "The whole model, all joints free": WHOLE,
    "What is missing": VERDICTS,
    "State of the sampler": SAMPLERS,
}
WORDS: dict[str, Word] = {word.key: word for words in GROUPS.values() for word in words}


def word_of(key: str) -> Word:
    """Return the word with a key.

    Parameters
    ----------
    key
        ``group-word``, as ``fit-converged``.

    Returns
    -------
    Word

    Raises
    ------
    KeyError
        Where there is no such word.
    """
    return WORDS[key]
