"""The locking plan as text for the terminal: summary of `model.plan` in, tables and lines out."""

from __future__ import annotations

from haptid.report.locking_plan.tables import (
    COUNTS_HEADER,
    ERRORS_HEADER,
    NO_POSTURES,
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
from haptid.support.tables import Table, Told


def tell_plan(plan: Data) -> Told:
    """Tell the plan.

    Parameters
    ----------
    plan
        Content of the plan's JSON file.

    Returns
    -------
    list
        Order, counts of parameters, table of ones, what stays unidentifiable and the proposed tests.
    """
    order = ", ".join(configuration(joints) for joints in plan["locking_order"])
    base = plan["base_parameters"]
    header = ["", *(configuration(stage["free_joints"]) for stage in plan["stages"])]
    told = [
        plan["title"],
        f"Locking order: {order}",
        f"Base parameters of the full model: {base['count']} (exact), {base['rank_numeric']} (numeric rank); "
        "these tests reach "
        f"{base['reached_with_locked_joints_at_home']} with the locked joints at home, "
        f"{base['reached_with_locked_joints_anywhere']} over postures",
        f"Unknowns: {plan['unknowns_at_once']} at once, at most {plan['largest_stage']} in one stage",
        "",
        Table(header=COUNTS_HEADER, rows=counts(plan)),
        "",
        "Parameters first met in each configuration:",
        Table(header=header, rows=ones(plan)),
        "",
        "Stays unidentifiable:",
        *(f"- {', '.join(entry['what'])}: {entry['why']}" for entry in plan["unidentifiable"]),
    ]
    return [*told, *_describe_design(plan)]


def _describe_design(plan: Data) -> Told:
    if "postures" not in plan:
        return []
    rows = posture_rows(plan)
    return [
        "",
        "Proposed runs, cosines of amplitude [N m or N] at frequency [rad/s]:",
        Table(header=RUNS_HEADER, rows=run_rows(plan)),
        *(f"joint {one['joint']}: {text}" for one in plan["excitation"] for text in one.get("warnings", [])),
        "",
        "Expected standard errors, plain runs and proposed ones:",
        Table(header=ERRORS_HEADER, rows=error_rows(plan)),
        "",
        posture_sentence(plan),
        Table(header=POSTURES_HEADER, rows=rows) if rows else NO_POSTURES,
    ]
