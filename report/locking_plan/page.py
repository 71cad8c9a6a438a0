"""The page of a locking plan: summary of `model.plan` in, `Page` out.

It shows the locking order, the table of ones, equations, unidentifiable parameters, and proposed runs and postures.
"""

from __future__ import annotations

from haptid.report.common.page import Page, Section, Table
from haptid.report.locking_plan.tables import (
    COUNTS_HEADER,
    ERRORS_HEADER,
    NO_POSTURES,
    POSTURES_HEADER,
    Data,
    configuration,
    counts,
    error_rows,
    locking_table,
    ones,
    posture_rows,
    posture_sentence,
    run_rows,
)


def plan_page(plan: Data) -> Page:
    """Render the plan as a self-contained page.

    Parameters
    ----------
    plan
        Content of the plan's JSON file.

    Returns
    -------
    Page
        Content of the page; the sections on the design are left out where the plan has no postures.
    """
    base = plan["base_parameters"]
    order = ", ".join(configuration(joints) for joints in plan["locking_order"])
    header = ["parameter", *(configuration(stage["free_joints"]) for stage in plan["stages"])]
    sections = [
        _order_section(plan),
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
    return Page(title=f"Locking plan: {plan['title']}", lead=lead, sections=sections, synthetic=None, footer=footer)


def _order_section(plan: Data) -> Section:
    joints = sorted({j for stage in plan["stages"] for j in stage["free_joints"]})
    locked = Table(
        header=["configuration", *(f"joint {j}" for j in joints)],
        rows=locking_table(plan),
        caption="L locked, U unlocked",
    )
    reached = Table(
        header=COUNTS_HEADER,
        rows=counts(plan),
        caption="A new parameter is one that no earlier configuration contains.",
    )
    return Section(title="Order", anchor="order", tables=[locked, reached])


def _design_sections(plan: Data) -> list[Section]:
    if "postures" not in plan:
        return []
    rows = posture_rows(plan)
    warnings = [f"Joint {one['joint']}: {text}" for one in plan["excitation"] for text in one.get("warnings", [])]
    return [
        Section(
            title="Proposed postures",
            anchor="postures",
            paragraphs=[posture_sentence(plan), *([] if rows else [NO_POSTURES])],
            tables=[Table(header=POSTURES_HEADER, rows=rows)] if rows else [],
        ),
        Section(
            title="Proposed runs",
            anchor="runs",
            paragraphs=warnings,
            tables=[
                Table(
                    header=["joint", "amplitude [N m or N] at frequency [rad/s]"],
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
