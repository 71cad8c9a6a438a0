"""Sections on one configuration: its step, traces and prediction in; `Section`s out.

They show measured and simulated positions, friction, what is left, and parameters with their status. They need nothing
of other configurations, so that the pictures of several are drawn side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from haptid.identification.baseline.friction_loop import friction_loop
from haptid.identification.baseline.prediction import Prediction, predict_unseen
from haptid.identification.output.cycle_amplitudes import cycle_amplitudes
from haptid.identification.output.plain_comparison import constant_torques
from haptid.identification.output.summary import (
    attention,
    residual_unit,
    tell_uncertain,
    uncertain_ids,
    worst_score,
)
from haptid.identification.output.traces import Trace, traces_of
from haptid.identification.result.outcome import UNCERTAIN
from haptid.identification.sequence.outcome_sentence import tell_outcome
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.report.common.cycles import cycles_picture
from haptid.report.common.numbers import HALF_WIDTH_95, with_error
from haptid.report.common.page import Cell, Picture, Section, Table, word_cell
from haptid.report.identification.figures import run_picture
from haptid.report.identification.friction_figures import friction_picture
from haptid.report.identification.parameter_figures import correlation_table, interval_picture
from haptid.report.identification.plain_section import plain_section
from haptid.report.identification.residual_figures import correlation_picture
from haptid.support.numbers import says_nothing, write_interval

FIRST_SHOWN, RUNS_IN_A_ROW = 3, 2
"""Runs that are drawn before the reader unfolds the others, and most runs of one picture."""
PARTS = 6
"""Parts of drawing a configuration: simulation, prediction, and four sections."""
MOST_CORRELATED = 3
"""Most runs of the picture of correlations."""
LARGEST_P_OF_SCATTER = 1e-3
"""Largest p-value at which amplitudes of cycles are drawn: one run in a thousand scatters as much by chance."""

NOT_DRAWN_AGAIN = (
    "The fit leaves nothing but the sensor's noise: friction, residual and intervals are drawn for the first posture "
    "of these joints."
)


def _ignore_part(part: str, done: float) -> None:
    """Take what a part does and the share that is done before it, and do nothing."""


def draw_configuration(
    step: Step, simulator_of: Callable[[Equations], Simulator], begins: Callable[[str, float], None] = _ignore_part
) -> tuple[Section, ...]:
    """Simulate the runs of one configuration at its estimates, and draw them; a process of its own may do it.

    Parameters
    ----------
    step
        Configuration with its fit.
    simulator_of
        Function from equations to a simulator; picklable where another process draws.
    begins
        Told of each part before it begins: what it does, and the share of all parts that is done, from 0 to 1.

    Returns
    -------
    tuple of Section
        As `configuration_sections` returns them.
    """
    begins("simulating the runs", 0.0)
    traces = traces_of(step, simulator_of)
    begins("predicting an unseen run", 1 / PARTS)
    # One posture of a joint shows how both models predict it; the tables of the others say the rest.
    compared = step.compared if step.configuration.number == 1 else None
    return configuration_sections(step, traces, predict_unseen(compared), begins)


def configuration_sections(
    step: Step,
    traces: Sequence[Trace],
    prediction: Prediction | None,
    begins: Callable[[str, float], None] = _ignore_part,
) -> tuple[Section, ...]:
    """Show one configuration.

    Parameters
    ----------
    step
        Configuration with its fit.
    traces
        Measured and simulated positions of its runs.
    prediction
        An unseen run as fit and plain model predict it; None where there is none.
    begins
        As `draw_configuration` takes it.

    Returns
    -------
    tuple of Section
        The fit; further runs; friction, residual and intervals; the plain model.
    """
    begins("drawing runs", 2 / PARTS)
    parts = [_configuration(step, traces)]
    begins("drawing further runs", 3 / PARTS)
    parts += _further_runs(step, traces)
    begins("drawing friction and residual", 4 / PARTS)
    parts.append(_diagnosis(step, traces))
    begins("drawing the plain model", 5 / PARTS)
    if step.compared is not None and step.compared.baseline is not None:
        parts.append(plain_section(step, step.compared.baseline, step.compared, prediction))
    return tuple(parts)


def _configuration(step: Step, traces: Sequence[Trace]) -> Section:
    fit = step.fit
    outcome = tell_outcome(step)
    said = [f"Outcome: {outcome}.", *(one for one in attention(step) if one != outcome), *fit.notes]
    return Section(
        title=step.configuration.name.capitalize(),
        anchor=step.configuration.anchor,
        paragraphs=tuple(s for s in (step.configuration.locked, *said) if s),
        pictures=_run_pictures(step, _first_shown(traces)),
        tables=tuple(
            t for t in (_parameters(step), _profiles(step), _combinations(step), _runs(step), _basins(step)) if t.rows
        ),
    )


def _first_shown(traces: Sequence[Trace]) -> list[Trace]:
    """Return a fitted run and the first that no fit saw."""
    fitted = [t for t in traces if t.score.use == "fit"]
    others = [t for t in traces if t.score.use == "validate"]
    return (fitted[len(fitted) // 2 :][:1] + others)[:FIRST_SHOWN]


def _run_pictures(step: Step, traces: Sequence[Trace]) -> tuple[Picture, ...]:
    return tuple(
        run_picture(traces[k : k + RUNS_IN_A_ROW], step.configuration.name)
        for k in range(0, len(traces), RUNS_IN_A_ROW)
    )


def _further_runs(step: Step, traces: Sequence[Trace]) -> list[Section]:
    """Return the folded section of the runs that are not drawn first; none where all are."""
    shown = [id(trace) for trace in _first_shown(traces)]
    others = [trace for trace in traces if id(trace) not in shown]
    if not others:
        return []
    title = f"{step.configuration.name.capitalize()}: {len(others)} more run{'s' * (len(others) > 1)}"
    return [Section(title=title, pictures=_run_pictures(step, others), folded=True)]


def _diagnosis(step: Step, traces: Sequence[Trace]) -> Section:
    """Return the section on friction, what is left, and how well each parameter is known."""
    name = step.configuration.name
    runs: dict[tuple[str, str], Run] = {(run.file, run.use): run for run in step.configuration.runs}
    shown = _first_shown(traces)
    drawn = not _repeats_an_earlier_posture(step)
    pictures: list[Picture | None] = [_friction(step)] if drawn else []
    if drawn and shown:
        pictures.append(correlation_picture(shown[:MOST_CORRELATED], name))
    if len(step.configuration.free_joints) == 1 and not step.torque_scored:
        found = [cycle_amplitudes(runs[t.score.file, t.score.use], t.simulated[:, 0]) for t in traces]
        scattered = [one for one in found if one is not None and one.p_value < LARGEST_P_OF_SCATTER]
        pictures += [cycles_picture(scattered, name)] if scattered else []
    if drawn:
        pictures.append(interval_picture(step.fit, name, uncertain_ids(step)))
    return Section(
        title=f"{name.capitalize()}: friction, residual, intervals",
        anchor=f"{step.configuration.anchor}-diagnosis",
        paragraphs=() if drawn else (NOT_DRAWN_AGAIN,),
        pictures=[picture for picture in pictures if picture is not None],
        tables=[table for table in (correlation_table(step.fit),) if table.rows],
    )


def _repeats_an_earlier_posture(step: Step) -> bool:
    """Say whether the same joints are drawn in an earlier posture, and this fit leaves nothing but noise."""
    worst = worst_score(step)
    quiet = worst is not None and worst.over_noise <= THRESHOLDS.largest_residual_as_noise
    return step.configuration.number > 1 and quiet and step.fit.outcome.label == "converged"


def _friction(step: Step) -> Picture | None:
    """Draw the friction of every free joint in the worst run; None where there is no inverse dynamics."""
    worst = worst_score(step)
    if step.compared is None or worst is None:
        return None
    runs = [run for run in step.compared.runs if (run.file, run.use) == (worst.file, worst.use)]
    loops = [friction_loop(step.compared, run, k) for run in runs[:1] for k in range(len(run.free_joints))]
    return friction_picture(loops, step.configuration.name) if loops else None


def _parameters(step: Step) -> Table:
    fit, uncertain = step.fit, uncertain_ids(step)
    unfit = Cell(text=tell_uncertain(step), word="unfit-uncertain")
    rows = [
        (
            q.id,
            _tell_value(q, value, std, fit.statuses[q.id]),
            q.unit,
            unfit if q.id in uncertain else word_cell("status", fit.statuses[q.id]),
            f"{q.initial:.3g}",
            f"[{q.lower:.3g}, {q.upper:.3g}]" if not q.fixed else "",
            q.description,
        )
        for q, value, std in zip(fit.equations.parameters, fit.theta, fit.std, strict=True)
    ]
    for one in constant_torques(step):
        status = unfit if one.status == UNCERTAIN else word_cell("status", one.status)
        meaning = f"constant torque, which {' and '.join(one.carried_by)} hold"
        rows.append((one.id, with_error(one.value, one.std), one.unit, status, "", "", meaning))
    header = ("parameter", "value ± std", "unit", "status", "first guess", "bounds", "meaning")
    return Table(header=header, rows=rows, caption="Parameters")


def _tell_value(q: Quantity, value: float, std: float, status: str) -> str:
    """Write a parameter with its error; no error that is far beyond the range, and then no value that is open."""
    if says_nothing(std, q.lower, q.upper):
        return "–" if status == "unidentifiable" else f"{value:.4g}"
    return with_error(value, std) if not q.fixed else f"{value:.4g}"


def _profiles(step: Step) -> Table:
    fit, rows = step.fit, []
    for id, one in fit.profiles.items():
        value, std, unit = fit.values[id], fit.std[fit.index(id)], fit.equations.parameter(id).unit
        ends = ["open" if end is None else f"{end:.6g}" for end in (one.lower, one.upper)]
        rows.append((id, *ends, write_interval(value - HALF_WIDTH_95 * std, value + HALF_WIDTH_95 * std, 6), unit))
    return Table(
        header=("parameter", "from", "to", "value ± 1.96 std", "unit"),
        rows=rows,
        caption="95 % intervals of the profile likelihood: all other parameters adapt to each end",
    )


def _combinations(step: Step) -> Table:
    rows = [
        (" + ".join(f"{c:.4g}·{id}" for id, c in one.coefficients.items()), with_error(one.value, one.std))
        for one in step.fit.combinations
    ]
    return Table(
        header=("combination", "value ± std"), rows=rows, caption="What the data alone know of open parameters"
    )


def _runs(step: Step) -> Table:
    unit = residual_unit(step)
    rows = [
        (s.file, s.use, ", ".join(f"{x:.3g}" for x in s.rmse), f"{s.over_noise:.3f}", f"{s.nrmse:.2e}")
        for s in step.fit.runs
    ]
    excluded = [(r.file, "excluded", "", "", r.reason) for r in step.configuration.runs if r.use == "excluded"]
    header = ("run", "use", f"RMS [{unit}]", "RMS / noise", "RMS / range")
    return Table(header=header, rows=[*rows, *excluded], caption="Runs")


def _basins(step: Step) -> Table:
    rows = [
        (f"{k + 1}", f"{b.over_noise:.4f}", ", ".join(map(str, b.starts)), str(b.simulations))
        for k, b in enumerate(step.fit.basins)
    ]
    header = ("minimum", "RMS / noise", "reached by starts", "simulations")
    return Table(header=header, rows=rows, caption="Minima that the starts reached")
