"""The locking plan as text for the terminal and as a page: the table of ones, the order, what stays unidentifiable."""

from __future__ import annotations

from typing import Any

from report.page import Section, Table, render_page

Data = dict[str, Any]


def configuration(joints: list[int]) -> str:
    """Return ``4`` or ``0+1``."""
    return "+".join(str(j) for j in joints)


def ones(plan: Data) -> list[list[str]]:
    """Return one row per parameter of the full model: its name, then 1 in the configuration that meets it first."""
    return [[key, *("1" if key in stage["new"] else "" for stage in plan["stages"])] for key in plan["parameters"]]


def locking_table(plan: Data) -> list[list[str]]:
    """Return one row per configuration: number, then L (locked) or U (unlocked) for each joint."""
    joints = sorted({j for stage in plan["stages"] for j in stage["free_joints"]})
    return [
        [str(n), *("U" if j in stage["free_joints"] else "L" for j in joints)]
        for n, stage in enumerate(plan["stages"], start=1)
    ]


def counts(plan: Data) -> list[list[str]]:
    """Return one row per configuration: free joints, parameters contained, new ones, combinations."""
    return [
        [
            configuration(stage["free_joints"]),
            str(len(stage["contains"])),
            str(len(stage["new"])),
            str(stage["joint_parameters"]),
            str(stage["combinations_at_home"]),
            str(stage["combinations_anywhere"]),
            str(stage["new_combinations"]),
        ]
        for stage in plan["stages"]
    ]


COUNTS_HEADER = (
    "free joints",
    "inertial parameters in it",
    "new ones",
    "friction, spring, gain",
    "combinations at home",
    "combinations over postures",
    "new combinations",
)


def plan_text(plan: Data) -> str:
    """Return the plan as text."""
    order = ", ".join(configuration(joints) for joints in plan["locking_order"])
    base = plan["base_parameters"]
    header = ["", *(configuration(stage["free_joints"]) for stage in plan["stages"])]
    lines = [
        plan["title"],
        f"Locking order: {order}",
        f"Base parameters of the full model: {base['count']} (exact), {base['rank_numeric']} (numeric rank); "
        "these tests reach "
        f"{base['reached_with_locked_joints_at_home']} with the locked joints at home, "
        f"{base['reached_with_locked_joints_anywhere']} over postures",
        f"Unknowns: {plan['unknowns_at_once']} at once, at most {plan['largest_stage']} in one stage",
        "",
        *_columns(list(COUNTS_HEADER), counts(plan)),
        "",
        "Parameters first met in each configuration:",
        *_columns(header, ones(plan)),
        "",
        "Stays unidentifiable:",
    ]
    lines += [f"- {', '.join(entry['what'])}: {entry['why']}" for entry in plan["unidentifiable"]]
    return "\n".join(lines + _design_text(plan))


def _design_text(plan: Data) -> list[str]:
    if "postures" not in plan:
        return []
    lines = [
        "",
        "Proposed runs, cosines of amplitude [N m] at frequency [rad/s]:",
        *_columns(RUNS_HEADER, run_rows(plan)),
    ]
    lines += [f"joint {one['joint']}: {text}" for one in plan["excitation"] for text in one.get("warnings", [])]
    lines += ["", "Expected standard errors, plain runs and proposed ones:", *_columns(ERRORS_HEADER, error_rows(plan))]
    lines += ["", posture_sentence(plan), *_columns(POSTURES_HEADER, posture_rows(plan))]
    return lines


RUNS_HEADER = ["joint", "runs"]
ERRORS_HEADER = ["joint", "parameter", "first guess", "before", "after", "unit"]
POSTURES_HEADER = ["free joints", "locked at [rad] (- free)"]


def run_rows(plan: Data) -> list[list[str]]:
    """Return one row per joint: its proposed runs, or why there are none."""
    return [
        [
            str(one["joint"]),
            one.get("reason")
            or ", ".join(f"{run['amplitude_Nm']:.3g} at {run['frequency_rad_s']:.3g}" for run in one["runs"]),
        ]
        for one in plan["excitation"]
    ]


def error_rows(plan: Data) -> list[list[str]]:
    """Return one row per joint and parameter: first guess, expected standard error before and after."""
    return [
        [
            str(one["joint"]),
            p["id"],
            f"{p['initial']:.3g}",
            f"{p['std_before']:.2g}",
            f"{p['std_after']:.2g}",
            p["unit"],
        ]
        for one in plan["excitation"]
        for p in one.get("expected", [])
    ]


def posture_rows(plan: Data) -> list[list[str]]:
    """Return one row per proposed test: free joints, positions of the locked ones."""
    return [
        [
            configuration(test["free_joints"]),
            ", ".join(
                "-" if j in test["free_joints"] else f"{x:+.3f}" for j, x in enumerate(test["locked_positions_rad"])
            ),
        ]
        for test in plan["postures"]["tests"]
    ]


def posture_sentence(plan: Data) -> str:
    """Return what the proposed postures buy."""
    found = plan["postures"]
    return (
        f"Expected torque error of the full model (rms over rms, coefficients fitted to "
        f"{100 * found['coefficient_accuracy']:.2g} %): {100 * found['torque_error_first_guesses']:.2g} % from the "
        f"first guesses, {100 * found['torque_error_home']:.2g} % after the tests at home, "
        f"{100 * found['torque_error_planned']:.2g} % with the proposed postures."
    )


def _columns(header: list[str], rows: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [header, *rows]
    ]


def plan_page(plan: Data) -> str:
    """Return the plan as a self-contained page."""
    base = plan["base_parameters"]
    order = ", ".join(configuration(joints) for joints in plan["locking_order"])
    joints = sorted({j for stage in plan["stages"] for j in stage["free_joints"]})
    header = ["parameter", *(configuration(stage["free_joints"]) for stage in plan["stages"])]
    sections = [
        Section(
            title="Order",
            anchor="order",
            tables=[
                Table(
                    header=["configuration", *(f"joint {j}" for j in joints)],
                    rows=locking_table(plan),
                    caption="L locked, U unlocked",
                ),
                Table(
                    header=COUNTS_HEADER,
                    rows=counts(plan),
                    caption="A new parameter is one that no earlier configuration contains.",
                ),
            ],
        ),
        Section(
            title="Table of ones",
            anchor="ones",
            tables=[
                Table(header=header, rows=ones(plan), caption="1: the parameter is first met in this configuration."),
            ],
        ),
        Section(title="Equations", anchor="equations", tables=[_equations(plan)]),
        Section(
            title="What stays unidentifiable",
            anchor="unidentifiable",
            tables=[
                Table(header=["what", "why"], rows=[[", ".join(e["what"]), e["why"]] for e in plan["unidentifiable"]])
            ],
        ),
        Section(
            title="Base parameters of the full model",
            anchor="base",
            folded=True,
            tables=[
                Table(
                    header=["", "combination"],
                    rows=[[str(n), text] for n, text in enumerate(base["formulas"], start=1)],
                )
            ],
        ),
        *_design_sections(plan),
        Section(title="Assumptions of the device file", anchor="assumptions", paragraphs=plan["assumptions"]),
    ]
    lead = (
        f"Lock the joints in the order {order}. The full model has {base['count']} base parameters; these tests reach "
        f"{base['reached_with_locked_joints_at_home']} with the locked joints at home and "
        f"{base['reached_with_locked_joints_anywhere']} over other lock postures."
    )
    footer = [f"{name} {number}" for name, number in plan["software"].items()]
    return render_page(
        title=f"Locking plan: {plan['title']}", lead=lead, sections=sections, synthetic=None, footer=footer
    )


def _design_sections(plan: Data) -> list[Section]:
    if "postures" not in plan:
        return []
    warnings = [f"Joint {one['joint']}: {text}" for one in plan["excitation"] for text in one.get("warnings", [])]
    return [
        Section(
            title="Proposed postures",
            anchor="postures",
            paragraphs=[posture_sentence(plan)],
            tables=[Table(header=POSTURES_HEADER, rows=posture_rows(plan))],
        ),
        Section(
            title="Proposed runs",
            anchor="runs",
            paragraphs=warnings,
            tables=[
                Table(
                    header=["joint", "amplitude [N m] at frequency [rad/s]"],
                    rows=run_rows(plan),
                    caption="Cosine torques that shrink the expected standard errors most (D-optimal).",
                ),
                Table(
                    header=ERRORS_HEADER,
                    rows=error_rows(plan),
                    caption="Standard errors expected of as many runs of one amplitude (before) and of these (after).",
                ),
            ],
        ),
    ]


def _equations(plan: Data) -> Table:
    rows = [
        [
            configuration(stage["free_joints"]),
            one["id"],
            f"{one['initial']:.4g} ± {one['prior_std']:.2g}",
            one["unit"],
            _formula(one["of"]),
        ]
        for stage in plan["stages"]
        for one in stage["coefficients"]
    ]
    return Table(
        header=["free joints", "coefficient", "first guess", "unit", "of the links"],
        rows=rows,
        caption="Coefficients of each equation, locked joints at home; m, m·c and L about the link's own frame.",
    )


def _formula(factors: dict[str, float]) -> str:
    parts = [
        f"{'−' if factor < 0 else '+'} {'' if abs(factor) == 1 else f'{abs(factor):.4g} '}{name}"
        for name, factor in factors.items()
    ]
    return " ".join(parts).removeprefix("+ ")
