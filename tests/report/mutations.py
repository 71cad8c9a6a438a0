"""Errors in pages, one at a time: a text in ``report/``, what stands in its place, and the tests that must fail."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutation:
    """An error put into one place.

    Parameters
    ----------
    name
        What a reader of the page would see.
    file
        File below ``report/``, or beside it where a page takes its line from there.
    old, new
        Text that stands there exactly once, and what replaces it.
    test
        File below ``tests/report/`` that must notice.
    """

    name: str
    file: str
    old: str
    new: str
    test: str


def of(file: str, test: str, *changes: tuple[str, str, str]) -> tuple[Mutation, ...]:
    """Return the mutations of one file; a change is its name, the old and the new text."""
    return tuple(Mutation(name=name, file=file, old=old, new=new, test=test) for name, old, new in changes)


DISCREPANCY = of(
    "discrepancy/page.py",
    "discrepancy/test_discrepancy_page.py",
    (
        "a tenth of the standard deviation",
        "with_error(x.value, x.std), x.unit",
        "with_error(x.value, x.std / 10), x.unit",
    ),
    (
        "an interval of ±0.67 σ",
        "for end in estimate.interval)",
        "for end in (estimate.value - 0.67 * estimate.std, estimate.value + 0.67 * estimate.std))",
    ),
    ("the ends of an interval swapped", "for end in estimate.interval)", "for end in estimate.interval[::-1])"),
    (
        "before for after in words",
        "it misses them by {in_thousandths(gap.after, unit)}",
        "it misses them by {in_thousandths(gap.before, unit)}",
    ),
    (
        "after for before in words",
        "misses {runs} by {in_thousandths(gap.before, unit)}",
        "misses {runs} by {in_thousandths(gap.after, unit)}",
    ),
    (
        "times the noise before for after",
        "{times(gap.after / gap.noise)} the noise",
        "{times(gap.before / gap.noise)} the noise",
    ),
    ("closes 100 − X in words", "which closes {tell_share(share)}", "which closes {tell_share(1.0 - share)}"),
    ("the fitted runs for the unseen", 'in ("sealed", "validate", "fit") if', 'in ("fit", "validate", "sealed") if'),
    (
        "before and after swapped in the table",
        "in (gap.before, gap.after, gap.noise)]",
        "in (gap.after, gap.before, gap.noise)]",
    ),
    (
        "closes 100 − X in the table",
        "(gap.closed_beside_scatter) for",
        "(1.0 - (gap.closed_beside_scatter or 0.0)) for",
    ),
    ("no scatter beside the gap", "name: tell_share(gap.closed_beside_scatter)", "name: tell_share(gap.closed)"),
    ("rad for mrad", "plain(factor * rms, 3)", "plain(rms, 3)"),
    (
        "worst for best among the models",
        "key=lambda t: t.candidate.criterion)",
        "key=lambda t: -t.candidate.criterion)",
    ),
    (
        "a gain of the other sign",
        "write_gain(before.bic - t.candidate.bic)",
        "write_gain(t.candidate.bic - before.bic)",
    ),
    ("half the evidence", "write_gain(2 * (t.candidate", "write_gain((t.candidate"),
    ("the nominal model taken", '"yes" if t is taken else ""', '"yes" if t is found.plain else ""'),
    ("parameters after for before", 'f"{base[p.id]:.5g}"', 'f"{final[p.id]:.5g}"'),
    ("a change of the other sign", "(after / before - 1)", "(before / after - 1)"),
    ("degrees of freedom off by one", 'f"{s.dof}"', 'f"{s.dof - 1}"'),
    ("p by signs for p", 'else f"{s.family_p:.2g}"', "else _write_flipped(s)"),
    ("the smallest effect ten times as small", "{d.size:.2g}", "{d.size / 10:.2g}"),
    ("the share of bags that lose the name", 'f"{100 * share:.0f} %"', 'f"{100 - 100 * share:.0f} %"'),
    (
        "all for the best starts",
        "best, tried = finding.search.base.reached,",
        "best, tried = len(finding.search.trials),",
    ),
)
UNNAMED_SECTION = of(
    "discrepancy/unnamed_section.py",
    "discrepancy/test_discrepancy_page.py",
    ("the torque's error a tenth", "with_error(y, std)) for x, y, std", "with_error(y, std / 10)) for x, y, std"),
    ("the share that is not closed", "{100 * max(shape.closed, 0.0):.1f}", "{100 - 100 * max(shape.closed, 0.0):.1f}"),
)
MOTION_PICTURES = of(
    "discrepancy/motion_pictures.py",
    "discrepancy/test_discrepancy_page.py",
    ("the picture's curves swapped", "axis.plot(curve.run.t, curve.before,", "axis.plot(curve.run.t, curve.after,"),
    ("a band of 1 σ", "band = [2 * factor * s", "band = [factor * s"),
)
TORQUE = of(
    "discrepancy/torque_gap_page.py",
    "discrepancy/test_gap_pages.py",
    ("closes 100 − X", "tell_share(gap.closed, 0)", "tell_share(1.0 - (gap.closed or 0.0), 0)"),
    ("a tenth of the standard deviation", "model.std[quantity.id])", "model.std[quantity.id] / 10)"),
    (
        "effects swapped",
        "_value(found.base, quantity), _value(found.final",
        "_value(found.final, quantity), _value(found.base",
    ),
    ("BIC for evidence", "write_gain(c.bic), write_gain(c.evidence)", "write_gain(c.evidence), write_gain(c.bic)"),
    ("another candidate taken", '"yes" if c is step.taken', '"yes" if c is not step.taken'),
    ("directions swapped", '(left.up, "position grows"', '(left.down, "position grows"'),
    ("errors of two σ", "factor * left.std, fmt", "2 * factor * left.std, fmt"),
    ("a band of 1 σ", "2 * factor * s * left.noise", "factor * s * left.noise"),
)
TORQUE_ROWS = of(
    "discrepancy/page.py",
    "discrepancy/test_gap_pages.py",
    (
        "before and after of a torque swapped",
        "in (gap.before, gap.after, gap.noise)]",
        "in (gap.after, gap.before, gap.noise)]",
    ),
)
WHOLE = of(
    "discrepancy/whole_gap_page.py",
    "discrepancy/test_gap_pages.py",
    ("before and after swapped", "return row.before, row.after,", "return row.after, row.before,"),
    ("noise for expected", "row.expected, row.noise", "row.noise, row.expected"),
    ("the bars swapped", "[factor * r.before for r", "[factor * r.after for r"),
)
DRAWS = of(
    "discrepancy/full_model_section.py",
    "discrepancy/test_gap_pages.py",
    ("spread for residual", 'f"{j.rmse_rad:.2g}", f"{j.spread_rad:.2g}"', 'f"{j.spread_rad:.2g}", f"{j.rmse_rad:.2g}"'),
    ("a band of 1 σ below", "check.simulated[:, i] - 2 *", "check.simulated[:, i] - 1 *"),
)
IDENTIFICATION = of(
    "identification/page.py",
    "identification/test_identification_pages.py",
    ("best for worst joint", "np.nanmax([getattr(j, of) for j", "np.nanmin([getattr(j, of) for j"),
    ("the spread for the RMS", 'f"{j.rmse_rad:.3g}"', 'f"{j.spread_rad:.3g}"'),
    ("over noise for over expected", 'f"{j.over_expected:.2f}"', 'f"{j.rmse_over_noise:.2f}"'),
    ("a link's error a tenth", 'with_error(one["value"], one["std"])', 'with_error(one["value"], one["std"] / 10)'),
    ("the earlier test for the later", "with_error(*a.later)", "with_error(*a.earlier)"),
    ("p for 1 − p", 'f"{a.p:.2g}"', 'f"{1 - a.p:.2g}"'),
)
CONFIGURATION = of(
    "identification/configuration_sections.py",
    "identification/test_identification_pages.py",
    ("a tenth of the standard deviation", "with_error(value, std) if not", "with_error(value, std / 10) if not"),
    ("the bounds swapped", "[{q.lower:.3g}, {q.upper:.3g}]", "[{q.upper:.3g}, {q.lower:.3g}]"),
    ("the estimate for the first guess", 'f"{q.initial:.3g}"', 'f"{value:.3g}"'),
    (
        "an interval of 50 %",
        "value - HALF_WIDTH_95 * std, value + HALF_WIDTH_95 * std, 6",
        "value - 0.67 * std, value + 0.67 * std, 6",
    ),
    ("the profile's ends swapped", "in (one.lower, one.upper)", "in (one.upper, one.lower)"),
    ("a combination's error a tenth", "with_error(one.value, one.std))\n", "with_error(one.value, one.std / 10))\n"),
    (
        "RMS over range for RMS over noise",
        'f"{s.over_noise:.3f}", f"{s.nrmse:.2e}"',
        'f"{s.nrmse:.3f}", f"{s.over_noise:.2e}"',
    ),
    (
        "noisy postures left out",
        "> 1 and quiet and",
        "> 1 and not quiet and",
    ),
)
WORST_RUN = of(
    "../identification/output/summary.py",
    "identification/test_identification_pages.py",
    ("best for worst", "return max(unseen or", "return min(unseen or"),
    (
        "the fitted runs for the unseen",
        'unseen = [score for score in step.fit.runs if score.use == "validate"]',
        'unseen = [score for score in step.fit.runs if score.use == "fit"]',
    ),
)
GLANCE = of(
    "identification/glance.py",
    "identification/test_identification_pages.py",
    ("over the noise for the size", "in_thousandths(worst.rmse_rad, unit)", "in_thousandths(worst.over_noise, unit)"),
    ("over range for over noise", "plain(worst.over_noise, 3)", "plain(worst.nrmse, 3)"),
    ("the best joint of the device", "return max(pairs, key", "return min(pairs, key"),
    ("files of the device with a joint", "if file not in own]", "if file in own]"),
)
DIAGNOSIS = (
    *of(
        "discrepancy/glance.py",
        "discrepancy/test_discrepancy_page.py",
        ("before for after over the noise", "line.gap.after if line.names", "line.gap.before if line.names"),
        (
            "the fitted runs for the unseen",
            'in ("sealed", "validate", "fit") if name in finding.gaps)\n    unit = unit_for("rad"',
            'in ("fit", "validate") if name in finding.gaps)\n    unit = unit_for("rad"',
        ),
        ("the best run for the worst", "worst = max(curves", "worst = min(curves"),
        (
            "scatter told as a cause",
            "return named and bool(effects) and all(",
            "return named and bool(effects) and not all(",
        ),
    ),
    *of(
        "identification/parameter_figures.py",
        "identification/test_identification_pages.py",
        ("intervals of 50 %", "100 * HALF_WIDTH_95 * np", "100 * 0.67 * np"),
        ("a correlation of the other sign", 'f"{c:+.2f}"', 'f"{-c:+.2f}"'),
        ("doubt told of what is known", '"" if identified[i] else " (not', '"" if not identified[i] else " (not'),
    ),
    *of(
        "identification/friction_figures.py",
        "identification/test_identification_pages.py",
        ("measured for modelled", "loop.speed, loop.model,", "loop.speed, loop.measured,"),
    ),
    *of(
        "identification/residual_figures.py",
        "identification/test_residual_figures.py",
        ("half the spectrum", "power[1:] / (2.0 * step)", "power[1:] / (4.0 * step)"),
        ("lags in rows", "step * np.arange(1,", "1.0 * np.arange(1,"),
        ("the limits of 50 %", "(-HALF_WIDTH_95, HALF_WIDTH_95)", "(-0.67, 0.67)"),
    ),
    *of(
        "common/cycles.py",
        "identification/test_residual_figures.py",
        ("cycles with 1 σ", "100 * HALF_WIDTH_95 * one.std", "100 * one.std"),
        ("cycles told with 1 σ", "196 * error", "100 * error"),
    ),
)
PLAIN = of(
    "identification/plain_section.py",
    "identification/test_identification_pages.py",
    ("the lower end at 0.3 σ", "value - HALF_WIDTH_95 * std", "value - 0.3 * HALF_WIDTH_95 * std"),
    ("the lower end times 0.3", "(value - HALF_WIDTH_95 * std,", "(0.3 * (value - HALF_WIDTH_95 * std),"),
    ("the upper end at 0.67 σ", "value + HALF_WIDTH_95 * std", "value + 0.67 * std"),
    ("the models swapped", '(("model", "fit"), ("baseline", "plain"))', '(("baseline", "fit"), ("model", "plain"))'),
    ("a share for per cent", "100.0 * figures.torque_error", "figures.torque_error"),
    ("torque for position", "_numbers(figures.free_rmse),", "_numbers(figures.torque_rmse),"),
    (
        "the plain model's error a tenth",
        "rows.append((id, with_error(value, std)",
        "rows.append((id, with_error(value, std / 10)",
    ),
    ("the fit's error for the plain model", "outcome is Outcome.PLAIN else", "outcome is Outcome.FIXED else"),
)
PICTURES = (
    *of(
        "identification/figures.py",
        "identification/test_identification_pages.py",
        ("a band of 1 σ", "-2 * factor * trace.sigma[k], 2 *", "-factor * trace.sigma[k], "),
        (
            "the residual of the other sign",
            "factor * (trace.measured[:, k] - trace.simulated[:, k])",
            "factor * (trace.simulated[:, k] - trace.measured[:, k])",
        ),
    ),
    *of(
        "identification/plain_pictures.py",
        "identification/test_identification_pages.py",
        (
            "the models swapped",
            '"model": (SIMULATED, "fit", "-"), "baseline": (ACCENT, "plain model", "--")',
            '"model": (SIMULATED, "plain model", "-"), "baseline": (ACCENT, "fit", "--")',
        ),
    ),
    *of(
        "posterior/figures.py",
        "posterior/test_posterior_pages.py",
        ("the band of 50 %", "part.lower[-1], part.upper[-1]", "part.lower[0], part.upper[0]"),
        ("cycles with 1 σ", "100 * HALF_WIDTH_95 * std", "100 * std"),
        ("coverage for what is not covered", "{100 * c:.1f}", "{100 - 100 * c:.1f}"),
        ("the prior told for the posterior", "{posterior[i]:.3g} % with", "{prior[i]:.3g} % with"),
    ),
    *of(
        "discrepancy/stage_pictures.py",
        "discrepancy/test_discrepancy_page.py",
        ("the final model's residual", "(curve.run.y[:, 0] - curve.before)", "(curve.run.y[:, 0] - curve.after)"),
        ("scores told in per cent", "{score.family_p:.2g}", "{100 * score.family_p:.2g}"),
    ),
    *of(
        "discrepancy/where_pictures.py",
        "discrepancy/test_discrepancy_page.py",
        ("samples told for the gap", "{gap[k]:.1f} % of the gap", "{rows[k]:.1f} % of the gap"),
    ),
)
CALIBRATION = of(
    "calibration/page.py",
    "identification/test_identification_pages.py",
    ("a tenth of the standard deviation", "else with_error(value, std)", "else with_error(value, std / 10)"),
    ("a combination's error a tenth", "with_error(one.value, one.std)", "with_error(one.value, one.std / 10)"),
    ("the bounds swapped", "[{q.lower:.4g}, {q.upper:.4g}]", "[{q.upper:.4g}, {q.lower:.4g}]"),
    ("a band of 1 σ", "axhspan(-2 * noise, 2 * noise", "axhspan(-noise, noise"),
)
POSTERIOR = (
    *of(
        "posterior/page.py",
        "posterior/test_posterior_pages.py",
        ("the interval of 50 %", "*_list_ends(p, (0.95,)), p.unit, p.prior", "*_list_ends(p, (0.5,)), p.unit, p.prior"),
        (
            "the levels in the other order",
            "levels = tuple(parameters[0].intervals)",
            "levels = tuple(parameters[0].intervals)[::-1]",
        ),
        (
            "every column of 50 %",
            "ends = [p.intervals[level] for level in levels]",
            "ends = [p.intervals[0.5] for level in levels]",
        ),
        ("the mean for the median", "round_to_error(p.median, p.std),", "round_to_error(p.mean, p.std),"),
        ("bulk for tail", 'f"{p.diagnostics.ess_tail:.0f}"', 'f"{p.diagnostics.ess_bulk:.0f}"'),
        ("overlap for contraction", 'f"{p.contraction:.2g}"', 'f"{p.overlap:.2g}"'),
        ("the worst for the best noise model", "top = max(s.score", "top = min(s.score"),
        (
            "the fastest coordinate's autocorrelation",
            "{s.tau.max():.1f} steps, {known}",
            "{s.tau.min():.1f} steps, {known}",
        ),
        ("the most independent draws", "{s.effective.min():.0f}", "{s.effective.max():.0f}"),
        ("after for before of the next run", "{n.before:.2g} to {n.after:.2g}", "{n.after:.2g} to {n.before:.2g}"),
    ),
    *of(
        "posterior/overview.py",
        "posterior/test_posterior_pages.py",
        ("half the width", "(high - low) / 2 /", "(high - low) / 4 /"),
        ("the width of 50 %", "s.intervals[0.95]", "s.intervals[0.5]"),
        ("least for best known", "(ordered[0], ordered[-1])", "(ordered[-1], ordered[0])"),
        ("a prior of 50 %", "draws, [0.025, 0.975]", "draws, [0.25, 0.75]"),
    ),
    *of(
        "posterior/foreign_page.py",
        "posterior/test_posterior_pages.py",
        ("the interval of 50 %", "p.intervals[0.95]", "p.intervals[0.5]"),
        ("what is not covered", "{band.covered[content]:.0%}", "{1 - band.covered[content]:.0%}"),
    ),
)
PLAN = (
    *of(
        "locking_plan/tables.py",
        "locking_plan/test_plan_page.py",
        ("after for before", "{p['std_before']:.2g}", "{p['std_after']:.2g}"),
        ("frequency for amplitude", "{run['amplitude_Nm']:.3g} at", "{run['frequency_rad_s']:.3g} at"),
        ("at home for anywhere", 'str(stage["combinations_anywhere"])', 'str(stage["combinations_at_home"])'),
        (
            "locked for unlocked",
            '"U" if j in stage["free_joints"] else "L"',
            '"L" if j in stage["free_joints"] else "U"',
        ),
        ("the error at home for the planned one", "found['torque_error_planned']", "found['torque_error_home']"),
    ),
    *of(
        "locking_plan/page.py",
        "locking_plan/test_plan_page.py",
        ("the width of the prior a tenth", "{one['prior_std']:.2g}", "{one['prior_std'] / 10:.2g}"),
        (
            "the count at home for anywhere",
            "base['reached_with_locked_joints_anywhere']",
            "base['reached_with_locked_joints_at_home']",
        ),
        ("a factor's other sign", "'−' if factor < 0 else '+'", "'+' if factor < 0 else '−'"),
    ),
)
FROM_JSON = of(
    "from_json/page.py",
    "from_json/test_from_json_page.py",
    ("the interval of 50 %", 'p["intervals"]["0.95"]', 'p["intervals"]["0.5"]'),
    ("before and after swapped", '("before", "after", "noise"))', '("after", "before", "noise"))'),
    ("a tenth of the standard deviation", "with_error(value, std) if std", "with_error(value, std / 10) if std"),
)
NUMBERS = of(
    "common/numbers.py",
    "common/test_page.py",
    ("a tenth of every standard deviation", "± {std / scale:.{digits}f}", "± {std / scale / 10:.{digits}f}"),
    ("a digit too few", "math.floor(math.log10(std)) + 2", "math.floor(math.log10(std)) + 1"),
)
MUTATIONS = (
    *DISCREPANCY, *UNNAMED_SECTION, *MOTION_PICTURES, *TORQUE, *TORQUE_ROWS, *WHOLE, *DRAWS, *IDENTIFICATION,
    *CONFIGURATION, *WORST_RUN,
    *GLANCE, *DIAGNOSIS, *PLAIN, *PICTURES, *CALIBRATION,
    *POSTERIOR, *PLAN, *FROM_JSON, *NUMBERS,
)  # fmt: skip
