"""``posterior.html``: posteriors in, `Page` with intervals, predictions, noise model and diagnostics out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import round_to_error
from haptid.report.common.page import Page, Picture, Section, Table
from haptid.report.posterior.figures import bands, corner, cycles, ranks, widths
from haptid.report.posterior.overview import glance_table, lead, overview, physical, relative_widths
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.summary import ParameterSummary
from haptid.uq.thresholds import THRESHOLDS

BANDS = (
    "Left: what was measured and its 95 % predictive band. Right: what is left after the predictive median, with the "
    "bands of 50, 80 and 95 %. Rows of one cycle move together where amplitudes scatter, so a "
    "single run's coverage may stray."
)
INTERVALS = "Intervals are equal-tailed: as much posterior probability lies below as above."


def posterior_page(
    posteriors: Sequence[Posterior],
    *,
    title: str,
    synthetic: bool,
    footer: Sequence[str],
    full: Sequence[Section] = (),
    files: Sequence[str] = (),
) -> Page:
    """Render the page of all joints.

    Parameters
    ----------
    posteriors
        One posterior per joint.
    title
        Heading of the page.
    synthetic
        Whether the data are simulated by a virtual device.
    footer
        Provenance: command, seed, date, campaign.
    full
        Sections about the whole device.
    files
        Files of the result, relative to the page.

    Returns
    -------
    Page
        Content of the page.
    """
    sections = [overview(posteriors)] if len(posteriors) > 1 else []
    sections += [part for p in posteriors for part in _joint(p)]
    return Page(
        title=title, lead=lead(posteriors), sections=[*sections, *full], synthetic=synthetic, footer=footer,
        glance=glance_table(posteriors, files),
    )  # fmt: skip


def _joint(p: Posterior) -> list[Section]:
    coordinates = p.mode.density.coordinates
    flat = coordinates.values(p.draws.reshape(-1, p.draws.shape[-1]))
    names = coordinates.names
    scatter = flat[:, names.index("cycle_scatter")] if "cycle_scatter" in names else np.empty(0)
    picture = cycles(p.bands, scatter)
    cycle_pictures = [] if picture is None else [_picture(picture, _cycle_caption(p), "amplitude of each cycle")]
    return [
        Section(
            title=f"Joint {p.joint}",
            anchor=f"joint{p.joint}",
            paragraphs=[*(s.verdict for s in p.parameters if s not in physical(p)), _next_words(p), *p.notes],
            pictures=[_widths(p)],
            tables=[_intervals(p.parameters)],
        ),
        Section(
            title=f"Joint {p.joint}: predicted and measured",
            pictures=[
                *cycle_pictures,
                _picture(bands(p.bands), BANDS, f"predicted and measured {p.residual}s"),
            ],
        ),
        Section(
            title=f"Joint {p.joint}: noise model",
            paragraphs=[_choice_words(p)],
            tables=[_choice(p)],
            folded=True,
        ),
        Section(
            title=f"Joint {p.joint}: priors, diagnostics, corner and rank plots",
            paragraphs=[*_sampler_words(p)],
            pictures=[
                _picture(corner(flat, names, coordinates.logarithmic), "Corner plot of the draws.", "corner plot"),
                _picture(
                    ranks(p.draws, names),
                    "Rank plots: every ensemble's share in each range of ranks; level lines mean that they agree.",
                    "rank plots",
                ),
            ],
            tables=[_further_intervals(p.parameters), _diagnostics(p.parameters), *_sensitivity(p)],
            folded=True,
        ),
    ]


def _picture(made: Figure, caption: str, alt: str) -> Picture:
    return picture_of(made, caption=caption, alt=alt)


def _widths(p: Posterior) -> Picture:
    """Draw the posterior's width within the prior's."""
    return _picture(
        widths(*relative_widths(p)),
        "How well each parameter is known, the least known on top.",
        "widths of intervals and priors",
    )


def _intervals(parameters: Sequence[ParameterSummary]) -> Table:
    rows = [[p.id, p.description, p.verdict, *_list_ends(p, (0.95,)), p.unit, p.prior] for p in parameters]
    header = ["parameter", "meaning", "verdict", "median", "95 % interval", "unit", "prior"]
    return Table(header=header, rows=rows, caption=INTERVALS)


def _further_intervals(parameters: Sequence[ParameterSummary]) -> Table:
    levels = tuple(parameters[0].intervals)
    header = ["parameter", "median", *(f"{100 * level:.0f} % interval" for level in levels), "unit"]
    return Table(header=header, rows=[[p.id, *_list_ends(p, levels), p.unit] for p in parameters], caption=INTERVALS)


def _list_ends(p: ParameterSummary, levels: Sequence[float]) -> list[str]:
    ends = [p.intervals[level] for level in levels]
    return [
        round_to_error(p.median, p.std),
        *(f"{round_to_error(a, p.std)} … {round_to_error(b, p.std)}" for a, b in ends),
    ]


def _diagnostics(parameters: Sequence[ParameterSummary]) -> Table:
    header = ["parameter", "prior", "overlap", "posterior/prior width", "R̂", "bulk ESS", "tail ESS", "MCSE of the mean"]
    rows = [
        [
            p.id,
            p.prior,
            f"{p.overlap:.2g}",
            f"{p.contraction:.2g}",
            f"{p.diagnostics.rhat:.4f}",
            f"{p.diagnostics.ess_bulk:.0f}",
            f"{p.diagnostics.ess_tail:.0f}",
            f"{p.diagnostics.mcse_mean:.2g}",
        ]
        for p in parameters
    ]
    return Table(header=header, rows=rows, caption="Rank-normalised split R̂ and ESS over independent ensembles.")


def _sensitivity(p: Posterior) -> list[Table]:
    if not p.sensitivity:
        return []
    names = list(next(iter(p.sensitivity.values())))
    rows = [
        [n, *(f"{p.sensitivity[k][n][0]:.5g} ± {p.sensitivity[k][n][1]:.2g}" for k in p.sensitivity)] for n in names
    ]
    header = ["parameter", *(f"{k} prior width" for k in p.sensitivity)]
    return [Table(header=header, rows=rows, caption="Prior sensitivity: mean ± standard deviation.")]


def _choice(p: Posterior) -> Table:
    top = max(s.score for s in p.candidates)
    rows = [
        [s.model.words + (" (used)" if s is p.chosen else ""), f"{s.score:.1f}", f"{s.score - top:.1f}"]
        for s in p.candidates
    ]
    return Table(header=["noise model", "held-out log density", "below the best"], rows=rows)


def _choice_words(p: Posterior) -> str:
    if len(p.candidates) == 1:
        return f"Noise model, as asked for: {p.chosen.model.words}."
    return (
        f"Used: {p.chosen.model.words}. It is the simplest one within {THRESHOLDS.least_gain_of_held_out_score:g} "
        "of the best log predictive density of the runs that were not fitted."
    )


def _sampler_words(p: Posterior) -> list[str]:
    s = p.sample
    e, steps, walkers, _ = s.chain.shape
    known = "known" if s.reached else "NOT yet known to 1 % at 50 autocorrelation times: intervals may be somewhat off"
    words = [
        f"{e} independent ensembles of {walkers} walkers, {steps} steps each; autocorrelation time "
        f"{s.tau.max():.1f} steps, {known}; at least {s.effective.min():.0f} independent draws; "
        f"acceptance {s.acceptance.mean():.2f}.",
        f"Largest R̂ {p.worst_rhat:.4f}. "
        + ("All ensembles found the same mode." if p.modes == 1 else f"The ensembles found {p.modes} separate modes."),
        f"PSIS-LOO over cycles: {p.loo.elpd:.1f} ± {p.loo.std:.1f}, {int((p.loo.pareto_k > 0.7).sum())} of "
        f"{p.loo.pareto_k.size} Pareto k above 0.7.",
    ]
    if s.trials:
        tried = ", ".join(f"{name} {tau:.1f}" for name, tau in s.trials.items())
        words.append(f"Moves were chosen by the autocorrelation time of a trial: {tried} steps.")
    return words


def _next_words(p: Posterior) -> str:
    n = p.next_run
    if n is None:
        return ""
    unit = unit_for("N m", p.bands[0].run.prismatic)
    return (
        f"To narrow {n.parameter}, the least known: run A = {n.amplitude:.3g} {unit}, ω = {n.omega:.3g} rad/s for "
        f"{n.duration:.3g} s. The standard deviation of its coordinate, which is relative for a positive parameter, "
        f"should go from {n.before:.2g} to {n.after:.2g} "
        f"({n.repeat:.2g} by repeating the most useful of the present runs)."
    )


def _cycle_caption(p: Posterior) -> str:
    return (
        "Amplitude of each cycle, less 1, with 95 % interval given the data (orange: runs not fitted); "
        f"right, the scatter's posterior. {p.chosen.model.words}."
    )
