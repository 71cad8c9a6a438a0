"""The page of a calibrated FMU: `Calibration` in, `Page` out.

It shows the parameters with their status, every run's figures by output, and measured and simulated outputs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from haptid.identification.calibration.calibrate import Calibration
from haptid.identification.calibration.words import RUNS, attention, run_rows, sentence_of
from haptid.measurement.values.run import Run
from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import with_error
from haptid.report.common.page import Cell, Page, Picture, Section, Table, status_cell
from haptid.report.common.style import BAND, RESIDUAL, figure, style
from haptid.report.common.words import word_of
from haptid.report.identification.figures import draw_over
from haptid.support.numbers import plain

METHOD = (
    "Residuals are measured minus simulated outputs over the noise of each output; 1.00 is the noise. Sensitivities "
    "are central differences; their steps are chosen so that the jumps of events are averaged. Standard deviations "
    "take the residuals' correlation into account. Status: identified; prior (the data did not halve the prior's "
    "width); unidentifiable (known only within 50 %, or in combinations); at_bound "
    "(stopped at the end of the range that it may take); fixed."
)
STARTS = (
    "identified.fmu is the same archive with the identified start values in its model description; parameters.ssv "
    "holds them as a parameter set. The binaries are unchanged and know the start values that were compiled into them: "
    "a host has to set those of the description before initialisation. fmpy does not by itself; give it start_values."
)


FILES = ("identified.fmu", "parameters.ssv", "identification.json")
"""Files that are written beside the page."""


def calibration_page(calibration: Calibration, data: Mapping[str, Any]) -> Page:
    """Compose the page of a calibration.

    Parameters
    ----------
    calibration
        Result of the fit.
    data
        Content of identification.json: command, software, measured.

    Returns
    -------
    Page
        Content of the page.
    """
    fit = calibration.fit
    said = tuple(f"{sentence[0].upper()}{sentence[1:]}." for sentence in attention(calibration))
    sections = [
        Section(title="Parameters", anchor="parameters", paragraphs=(METHOD, *said), tables=_parameters(calibration)),
        Section(
            title="Runs",
            anchor="runs",
            pictures=[_picture(calibration, run) for run in _choose_drawn(calibration)],
            tables=(Table(header=RUNS, rows=run_rows(calibration)),),
        ),
        Section(title="The FMU", anchor="fmu", paragraphs=(STARTS,), tables=(_minima(calibration),)),
    ]
    sentence = sentence_of(fit.outcome)
    return Page(
        title=calibration.campaign.title,
        lead=f"{calibration.campaign.model.name}: {sentence}.",
        sections=sections,
        synthetic=not calibration.campaign.measured,
        footer=(
            f"Command: {data['command']}",
            "Software: " + ", ".join(f"{name} {number}" for name, number in data["software"].items()),
        ),
        glance=_glance(calibration),
    )


def _glance(calibration: Calibration) -> Table:
    """Write the line of the first screen: verdict, worst run, what to do, and the files."""
    label = calibration.fit.outcome.label
    word, scores = word_of(f"fit-{label}"), calibration.fit.runs
    unseen = [score for score in scores if score.use == "validate"]
    worst = max(unseen or scores, key=lambda score: score.over_noise, default=None)
    over, run = ("–", "–") if worst is None else (plain(worst.over_noise, 3), f"{worst.file} ({worst.use})")
    verdict = Cell(text=word.text, word=word.key)
    row = (calibration.campaign.model.name, verdict, over, run, word.action, Cell(links=FILES))
    return Table(header=("model", "verdict", "× noise", "worst run", "what to do next", "files"), rows=[row])


def _parameters(calibration: Calibration) -> tuple[Table, ...]:
    fit = calibration.fit
    rows = [
        (
            q.structured,
            f"{value:.6g}" if q.fixed else with_error(value, std),
            q.unit,
            status_cell(fit.statuses[q.id], fit.outcome.label),
            f"{q.initial:.4g}",
            "" if q.fixed else f"[{q.lower:.4g}, {q.upper:.4g}]",
            q.description,
        )
        for q, value, std in zip(fit.equations.parameters, fit.theta, fit.std, strict=True)
    ]
    header = ("variable", "value ± std", "unit", "status", "first guess", "bounds", "meaning")
    tables = [Table(header=header, rows=rows)] if rows else []
    known = [
        (
            " + ".join(f"{c:.4g}·{fit.equations.parameter(id).structured}" for id, c in one.coefficients.items()),
            with_error(one.value, one.std),
        )
        for one in fit.combinations
    ]
    if known:
        caption = "What the data alone know of open parameters"
        tables.append(Table(header=("combination", "value ± std"), rows=known, caption=caption))
    return tuple(tables)


def _minima(calibration: Calibration) -> Table:
    rows = [
        (f"{k + 1}", f"{basin.over_noise:.4f}", ", ".join(map(str, basin.starts)))
        for k, basin in enumerate(calibration.fit.basins)
    ]
    header = ("minimum", "RMS / noise", "reached by starts")
    return Table(header=header, rows=rows, caption="Minima that the starts reached")


def _choose_drawn(calibration: Calibration) -> list[Run]:
    runs = [run for run in calibration.campaign.runs if run.file in calibration.simulated]
    return sorted(runs, key=lambda run: run.use != "validate")


def _picture(calibration: Calibration, run: Run) -> Picture:
    """Draw the outputs of a run, measured and simulated, each above its residual."""
    names, simulated = calibration.campaign.outputs, calibration.simulated[run.file]
    with style():
        made = figure(8.0, 2.8 * len(names))
        axes = made.subplots(2 * len(names), 1, sharex=True, squeeze=False, height_ratios=[2, 1] * len(names))[:, 0]
        for k, name in enumerate(names):
            unit = f" [{calibration.units[k]}]" if calibration.units[k] else ""
            above, below = axes[2 * k], axes[2 * k + 1]
            draw_over(above, run.t, run.y[:, k], simulated[:, k])
            above.set_ylabel(f"{name}{unit}")
            noise = run.sensor_std[k]
            below.axhspan(-2 * noise, 2 * noise, color=BAND, linewidth=0)
            below.plot(run.t, (run.y - simulated)[:, k], color=RESIDUAL, linewidth=0.5)
            below.set_ylabel(f"residual{unit}")
        axes[-1].set_xlabel("time [s]")
        handles, labels = axes[0].get_legend_handles_labels()
        made.legend(handles, labels, loc="outside lower center", ncols=2)
    caption = f"{run.file} ({run.use}): measured (wide) and simulated (narrow), residual (red) with the noise's ±2σ."
    return picture_of(made, caption=caption, alt=f"{run.file}, measured against simulated, with residuals")
