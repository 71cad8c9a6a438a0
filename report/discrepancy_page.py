"""The page of a search for missing physics: verdict first, pictures next, statistics last."""

from __future__ import annotations

import numpy as np

from discrepancy.finding import Curve, Finding
from discrepancy.where import Map
from report.numbers import with_error
from report.page import Picture, Section, Table, render_page
from report.style import ACCENT, MEASURED, RESIDUAL, SIMULATED, data_uri, figure, style


def before_after_picture(curves: tuple[Curve, ...]) -> Picture:
    """Measured and simulated position, residual before and after, on up to two runs that no fit saw."""
    shown = curves[:2]
    with style():
        made = figure(8.5, 4.2)
        axes = made.subplots(2, len(shown), squeeze=False, sharex="col", height_ratios=(1.4, 1))
        for column, curve in enumerate(shown):
            top, low = axes[0, column], axes[1, column]
            t, y = curve.run.t, curve.run.y[:, 0]
            top.plot(t, y, color=MEASURED, label="measured")
            top.plot(t, curve.before, color=ACCENT, ls="--", label="simulated before")
            top.plot(t, curve.after, color=SIMULATED, ls=":", label="simulated after")
            top.set_title(curve.run.file, fontsize=8)
            low.plot(t, 1e3 * (y - curve.before), color=ACCENT, lw=0.7)
            low.plot(t, 1e3 * (y - curve.after), color=SIMULATED, lw=0.7)
            low.axhspan(*(2e3 * s * curve.run.sensor_std[0] for s in (-1, 1)), color="#99e9f2", alpha=0.5, lw=0)
            low.set_xlabel("time [s]")
        axes[0, 0].set_ylabel("position [rad]")
        axes[1, 0].set_ylabel("residual [mrad]")
        axes[0, 0].legend(fontsize=7)
    caption = "Measured minus simulated, before (orange) and after (blue); the band is ±2σ of the sensor."
    return Picture(uri=data_uri(made), caption=caption, alt="measured and simulated position, before and after")


def where_picture(maps: tuple[Map, ...]) -> Picture:
    """Residual energy over the noise, per bin of each variable."""
    with style():
        made = figure(8.5, 2.4)
        for axis, m in zip(made.subplots(1, len(maps)), maps, strict=True):
            axis.bar(
                m.edges[:-1],
                m.excess / np.maximum(m.rows, 1.0),
                np.diff(m.edges),
                align="edge",
                color=RESIDUAL,
                alpha=0.75,
            )
            axis.set_xlabel(m.variable.replace("_", " "), fontsize=8)
        made.axes[0].set_ylabel("energy over the noise")
    return Picture(
        uri=data_uri(made),
        caption="Where the base model misses: mean squared residual above the sensor's noise, in σ².",
        alt="residual energy over position, speed, torque and time",
    )  # fmt: skip


def _effects(finding: Finding) -> Table:
    rows = [
        (e.id, e.formula, id, f"{with_error(value, std)} {unit}", f"{e.evidence:.0f}")
        for e in finding.judgement.effects
        for id, (value, std, unit) in e.parameters.items()
    ]
    return Table(header=("effect", "formula", "parameter", "value ± std", "evidence"), rows=rows)


def _ranking(finding: Finding) -> list[Table]:
    found = finding.search
    before = found.plain.candidate
    rows = [
        (
            " + ".join(t.solution.keys) or "noise alone",
            f"{before.bic - t.candidate.bic:.0f}",
            f"{2 * (t.candidate.prediction.score - before.prediction.score):.0f}",
            "yes" if t.adequate else "no",
            "yes" if t is found.best else "",
        )
        for t in sorted(found.trials, key=lambda t: t.candidate.criterion)
    ]
    return [
        Table(
            header=("effects", "gain in BIC", "evidence on unseen runs", "leaves only noise", "taken"),
            rows=rows,
            caption=f"Refitted with all parameters, over the base model, which leaves noise with p = "
            f"{min(found.plain.left.p, found.plain.left_p):.2g}",
        )
    ]


def _gaps(finding: Finding) -> Table:
    names = {"fit": "fitted runs", "validate": "runs that no fit saw"}
    rows = [
        (
            names[name],
            f"{g.before:.3g}",
            f"{g.after:.3g}",
            f"{g.noise:.3g}",
            "–" if g.closed is None else f"{100 * g.closed:.1f} %",
        )
        for name, g in finding.gaps.items()
    ]
    return Table(header=("", "RMS before [rad]", "RMS after [rad]", "sensor noise [rad]", "gap closed"), rows=rows)


def _moved(finding: Finding) -> Table:
    base, final = finding.search.plain.solution.values, finding.search.best.solution.values
    rows = [
        (
            p.id,
            f"{base[p.id]:.5g}",
            f"{final[p.id]:.5g}",
            f"{100 * (final[p.id] / base[p.id] - 1):+.1f} %" if base[p.id] else "–",
            p.unit,
        )
        for p in finding.search.plain.solution.equations.parameters
        if not p.fixed
    ]
    return Table(header=("parameter", "before", "after", "change", "unit"), rows=rows)


def _settle(finding: Finding) -> list[str]:
    proposal, shape = finding.judgement.next_experiment, finding.judgement.shape
    lines = []
    if proposal is not None:
        lines.append(
            f"The run that would tell: {proposal.as_json()['run']}; "
            f"there the rivals differ by {proposal.separation:.0f} times the noise."
        )
    if shape is not None:
        points = ", ".join(f"{x:.3g}: {y:.2g}" for x, y in zip(shape.knots, shape.torque, strict=True))
        lines.append(f"Remaining torque [N m] as a function of {shape.variable.replace('_', ' ')}: {points}.")
    return lines


def discrepancy_page(finding: Finding, title: str, *, measured: bool) -> str:
    """Render the page of one joint."""
    j = finding.judgement
    sections = [
        Section(
            title="Before and after", anchor="gap",
            pictures=[before_after_picture(finding.curves)], tables=[_gaps(finding)],
        ),
        Section(
            title="Where the gap was", anchor="where", pictures=[where_picture(finding.maps)],
            paragraphs=[
                f"{100 * r.share_of_gap:.0f} % of the gap lies at {r.variable.replace('_', ' ')} "
                f"{r.lower:.3g} to {r.upper:.3g}, "
                f"in {100 * r.share_of_rows:.0f} % of the samples."
                for r in finding.regions[:2]
            ],
        ),
    ]  # fmt: skip
    if j.effects and j.verdict != "nothing_missing":
        sections.insert(
            1, Section(title="What is missing", anchor="what", paragraphs=_settle(finding), tables=[_effects(finding)])
        )
    elif lines := _settle(finding):
        sections.insert(1, Section(title="What is known of it", anchor="what", paragraphs=lines))
    sections += [
        Section(
            title="What was tried", anchor="tried", tables=_ranking(finding),
            paragraphs=[
                "Evidence is twice the gain in log predictive score on runs that no fit saw; "
                "BIC charges each parameter ln n."
            ],
        ),
        Section(title="Parameters that moved", anchor="moved", tables=[_moved(finding)]),
    ]  # fmt: skip
    best, tried = finding.search.base.reached, len(finding.search.base.costs)
    footer = [
        f"{best} of {tried} starts reached the base model's best minimum; "
        f"{finding.search.simulations} simulations in {finding.wall_s:.0f} s."
    ]
    return render_page(
        title=f"Joint {finding.joint}: {title}",
        lead=j.sentence,
        sections=sections,
        synthetic=not measured,
        footer=footer,
    )
