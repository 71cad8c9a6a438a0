"""The locking plan as text for the terminal: summary of `model.plan` in, one text out."""

from __future__ import annotations

from haptid.report.locking_plan.tables import (
    COUNTS_HEADER,
    ERRORS_HEADER,
    POSTURES_HEADER,
    RUNS_HEADER,
    Data,
    configuration,
    counts,
    error_rows,
    ones,
    posture_rows,
    posture_sentence,
    run_rows,
)


def plan_text(plan: Data) -> str:
    """Write the plan as text of several lines.

    Parameters
    ----------
    plan
        Content of the plan's JSON file.

    Returns
    -------
    str
        Order, counts of parameters, table of ones, what stays unidentifiable and the proposed tests.
    """
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
        "Proposed runs, cosines of amplitude [N m or N] at frequency [rad/s]:",
        *_columns(RUNS_HEADER, run_rows(plan)),
    ]
    lines += [f"joint {one['joint']}: {text}" for one in plan["excitation"] for text in one.get("warnings", [])]
    lines += ["", "Expected standard errors, plain runs and proposed ones:", *_columns(ERRORS_HEADER, error_rows(plan))]
    lines += ["", posture_sentence(plan), *_columns(POSTURES_HEADER, posture_rows(plan))]
    return lines


def _columns(header: list[str], rows: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [header, *rows]
    ]
