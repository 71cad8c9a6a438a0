"""The page of an FMU's posterior: `ForeignPosterior` in, `Page` out."""

from __future__ import annotations

from collections.abc import Sequence

from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import round_to_error
from haptid.report.common.page import Page, Picture, Section, Table
from haptid.report.common.style import BAND, MEASURED, figure, style
from haptid.report.common.words import word_of
from haptid.report.posterior.figures import corner
from haptid.uq.foreign.infer import Band, ForeignPosterior
from haptid.uq.foreign.record import variable_names

METHOD = (
    "The likelihood takes the outputs' noise as white, times a common factor that is sampled too, and counts as many "
    "independent rows as the correlation time of the fit's residuals leaves. Intervals are equal-tailed."
)


def foreign_posterior_page(posterior: ForeignPosterior, footer: Sequence[str]) -> Page:
    """Compose the page of an FMU's posterior.

    Parameters
    ----------
    posterior
        Posterior of an FMU.
    footer
        Command, seed and date.

    Returns
    -------
    Page
        Content of the page.
    """
    campaign, drawn = posterior.calibrated.campaign, posterior.sample
    names = variable_names(posterior)
    flat = posterior.coordinates.values(drawn.flat())
    pairs = corner(flat, names, posterior.coordinates.logarithmic)
    sampler = (
        f"{drawn.chain.shape[0]} ensembles of {drawn.chain.shape[2]} walkers, {drawn.chain.shape[1]} steps, "
        f"autocorrelation time {drawn.tau.max():.1f} steps"
    )
    sections = [
        Section(
            title="Parameters",
            anchor="parameters",
            paragraphs=(METHOD, f"Sampler: {sampler}."),
            pictures=(picture_of(pairs, caption="Draws of every pair.", alt="pairs of parameters"),),
            tables=(_parameters(posterior, names),),
        ),
        Section(
            title="Runs",
            anchor="runs",
            pictures=[_picture(band, campaign.outputs) for band in posterior.bands],
            tables=(_runs(posterior),),
        ),
    ]
    lead = " ".join(p.verdict for p in posterior.parameters[:-1])
    if not posterior.sound:
        word = word_of(f"sampler-{posterior.state}")
        lead = f"{word.text.capitalize()}: {word.meaning} {word.action} {lead}"
    return Page(
        title=f"How well the parameters of {campaign.model.name} are known",
        lead=lead,
        sections=sections,
        synthetic=not campaign.measured,
        footer=footer,
    )


def _parameters(posterior: ForeignPosterior, names: Sequence[str]) -> Table:
    rows = []
    for name, p in zip(names, posterior.parameters, strict=True):
        low, high = (round_to_error(end, p.std) for end in p.intervals[0.95])
        rows.append((name, round_to_error(p.median, p.std), f"{low} … {high}", p.unit, p.prior, p.verdict))
    header = ("variable", "median", "95 % interval", "unit", "prior", "verdict")
    return Table(header=header, rows=rows)


def _runs(posterior: ForeignPosterior) -> Table:
    contents = tuple(posterior.bands[0].covered)
    header = ("run", "use", *(f"in the {content:.0%} band" for content in contents))
    rows = [
        (band.run.file, band.run.use, *(f"{band.covered[content]:.0%}" for content in contents))
        for band in posterior.bands
    ]
    return Table(header=header, rows=rows)


def _picture(band: Band, outputs: Sequence[str]) -> Picture:
    with style():
        made = figure(8.0, 2.0 * len(outputs) + 0.4)
        axes = made.subplots(len(outputs), 1, sharex=True, squeeze=False)[:, 0]
        for k, name in enumerate(outputs):
            axes[k].fill_between(band.run.t, band.lower[:, k], band.upper[:, k], color=BAND, linewidth=0)
            axes[k].plot(band.run.t, band.run.y[:, k], ".", color=MEASURED, markersize=2)
            axes[k].set_ylabel(name)
        axes[-1].set_xlabel("time [s]")
    caption = f"{band.run.file} ({band.run.use}): readings (black) in the 95 % band (shaded)."
    return picture_of(made, caption=caption, alt=f"{band.run.file}, readings and predictive band")
