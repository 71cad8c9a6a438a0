"""The first screen of ``posterior.html``: posteriors in, lead sentence and overview table out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.measurement.values.run import Array
from haptid.report.common.page import Cell, Section, Table
from haptid.report.common.words import Word, word_of
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.sampler_state import SamplerState
from haptid.uq.result.summary import ParameterSummary, limit_words
from haptid.uq.thresholds import THRESHOLDS

DOUBTED = "Do not use these intervals yet: read what the joint's first notes doubt."
"""What to do where the fit says that the model does not fit, or contradicts the posterior."""
KNOWN = 0.1
"""Half width of the 95 % interval over the value below which a parameter counts as known [1]."""


def lead(posteriors: Sequence[Posterior]) -> str:
    """Say for all joints how many parameters are known, which are set by their priors, and whether chains converged.

    Parameters
    ----------
    posteriors
        One for each joint.

    Returns
    -------
    str
        Sentences; joints are named where their model is doubted, and where their chains disagree or are short.
    """
    every = [(p.joint, s) for p in posteriors for s in physical(p)]
    open_ = [f"{s.id} of joint {j}" for j, s in every if _is_set_by_prior(s)]
    limits = [f"{s.id} of joint {j} ({_shown_width(s)})" for j, s in every if not _is_set_by_prior(s) and s.limit]
    known = sum(_is_known(s) for _, s in every)
    text = f"{known} of {len(every)} parameters are known to better than ±10 % (95 %)."
    text += f" Set by their priors: {', '.join(open_)}." if open_ else " None is set by its prior."
    text += f" At a bound, so that the data give a limit: {', '.join(limits)}." if limits else ""
    doubted = [p.joint for p in posteriors if p.doubts]
    warned = f"Do not use joint {_join(doubted)} yet: the notes of the joint say why. " if doubted else ""
    return f"{warned}{_describe_chains(posteriors)}{text}"


def _describe_chains(posteriors: Sequence[Posterior]) -> str:
    """Say which joints' chains are not sound, what no reader of the intervals may miss first."""
    joints: dict[SamplerState, list[int]] = {}
    for p in posteriors:
        joints.setdefault(p.state, []).append(p.joint)
    sentences: tuple[tuple[SamplerState, str], ...] = (
        ("ensembles_disagree", "Do not use joint {joints}: independent ensembles disagree. "),
        ("too_short", "Do not use joint {joints} yet: the chains are too short. "),
        ("short", "The chains of joint {joints} agree but are short: ends of intervals may move by a few percent. "),
    )
    return "".join(text.format(joints=_join(joints[state])) for state, text in sentences if state in joints)


def _is_set_by_prior(s: ParameterSummary) -> bool:
    return s.contraction > THRESHOLDS.largest_std_over_prior_std


def _is_known(s: ParameterSummary) -> bool:
    return width(s) < KNOWN and not _is_set_by_prior(s)


def _shown_width(s: ParameterSummary) -> str:
    """Write how well a parameter is known: a limit where it is at a bound, else its half-width in percent."""
    return f"±{100 * width(s):.2g} %" if s.limit is None else limit_words(s.limit, s.unit)


def sampler_word(p: Posterior) -> Word:
    """Return the word on the state of a joint's sampler.

    Parameters
    ----------
    p
        Posterior of one joint.

    Returns
    -------
    Word
    """
    return word_of(f"sampler-{p.state}")


def glance_table(posteriors: Sequence[Posterior], files: Sequence[str]) -> Table:
    """Write one line for each joint.

    Parameters
    ----------
    posteriors
        One for each joint.
    files
        Files of the result, relative to the page; those whose name has no joint's number stand with every joint.

    Returns
    -------
    Table
        State of the sampler, how many parameters are known, the best and the least known, what to do, and the files.
    """
    rows: list[tuple[str | Cell, ...]] = []
    for p in posteriors:
        word, every = sampler_word(p), sorted(physical(p), key=width)
        known = [s for s in every if _is_known(s)]
        ends = [f"{s.id} {_shown_width(s)}" for s in (every[0], every[-1])] if every else ["–", "–"]
        own = [file for file in files if "joint" not in file or file.rsplit(".", 1)[0].endswith(f"joint{p.joint}")]
        rows.append((
            Cell(text=f"joint {p.joint}", anchor=f"joint{p.joint}"), Cell(text=word.text, word=word.key),
            f"{len(known)} of {len(every)}", *ends, DOUBTED if p.doubts else word.action, Cell(links=own),
        ))  # fmt: skip
    header = ("joint", "sampler", "known to ±10 %", "best known", "least known", "what to do next", "files")
    return Table(header=header, rows=rows)


def _join(joints: Sequence[int]) -> str:
    return ", ".join(map(str, joints))


def physical(p: Posterior) -> list[ParameterSummary]:
    """Return the summaries of the equations' parameters, without those of the noise model.

    Parameters
    ----------
    p
        Posterior of one joint.

    Returns
    -------
    list of ParameterSummary
        In the order of the posterior.
    """
    ids = {q.id for q in p.mode.density.coordinates.free}
    return [s for s in p.parameters if s.id in ids]


def width(s: ParameterSummary) -> float:
    """Return the half-width of the 95 % interval over the absolute median [1].

    Parameters
    ----------
    s
        Summary of one parameter.

    Returns
    -------
    float
        Relative half-width [1].
    """
    low, high = s.intervals[0.95]
    return (high - low) / 2 / max(abs(s.median), 1e-300)


def relative_widths(p: Posterior) -> tuple[list[str], Array, Array]:
    """Return the half-width of each parameter's 95 % interval and of its prior's.

    Parameters
    ----------
    p
        Posterior of one joint.

    Returns
    -------
    names, posterior, prior
        Ids of the equations' parameters, and half-widths in percent of the absolute median, shape (n,) each.
    """
    shown, coordinates = physical(p), p.mode.density.coordinates
    draws = coordinates.values(coordinates.draw(np.random.default_rng(0), 2000))
    ends = np.quantile(draws, [0.025, 0.975], axis=0)
    scale = np.array([max(abs(s.median), 1e-300) for s in shown])
    places = [coordinates.names.index(s.id) for s in shown]
    prior = 100 * (ends[1] - ends[0])[places] / 2 / scale
    return [s.id for s in shown], np.array([100 * width(s) for s in shown]), prior


def overview(posteriors: Sequence[Posterior]) -> Section:
    """Return the table of all joints: best and least known parameter, scatter, next run, state of the sampler.

    Parameters
    ----------
    posteriors
        One for each joint.

    Returns
    -------
    Section
        Section with one table, one row for each joint.
    """
    rows = []
    for p in posteriors:
        ordered = sorted(physical(p), key=width)
        scatter = [s.verdict for s in p.parameters if s.id.endswith("_scatter")] or ["none needed by the data"]
        ends = [f"{s.id} {_shown_width(s)}" for s in (ordered[0], ordered[-1])] if ordered else ["–", "–"]
        wanted = f"A = {p.next_run.amplitude:.3g}, ω = {p.next_run.omega:.3g} rad/s" if p.next_run else "–"
        rows.append([f"{p.joint}", *ends, " ".join(scatter), wanted, sampler_word(p).text])
    header = ["joint", "best known", "least known", "amplitude scatter", "run to make next", "sampler"]
    return Section(title="All joints", anchor="overview", tables=[Table(header=header, rows=rows)])
