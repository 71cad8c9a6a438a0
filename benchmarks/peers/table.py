"""The results as a table and as a page."""

from __future__ import annotations

from typing import Any

from benchmarks.peers.problem import CASES

WHAT = "Seconds per start over the share of starts that reach the noise on a run that no fit saw."
NOTES = """
Read with care:

- Seconds are wall time on a machine that others used too (load before and after each contestant is in the JSON); CPU
  seconds stand beside them. Every contestant has one thread. Not counted: installation, compilation, and what a
  contestant prepares once (`preparation_s`).
- One judge for all: the virtual device's integrator with the returned parameters on the validation run, from the known
  start at rest. Where no start reached the noise, "to truth" is a lower bound: all the seconds spent.
- The other tools are used as somebody who knows them well would: logarithms of the parameters, Gauss-Newton curvature
  and an exponential integrator written by hand for CasADi (plain RK4 would need 33 steps a row), exact sensitivities
  and the input as a formula for AMICI, no order of Fs and Fc for anyone. ModestPy scales parameters by their bounds,
  with no other choice. Used so, CasADi needs no homotopy from these starts: on these two joints it differs in time.
- haptid is timed for a whole `fit` with one start: homotopy, polish, covariance and statuses; the others give
  parameters alone. Its lines differ in what simulates: FMUs and kernel take ten inner steps per row, the lines
  "2 steps/row" as many as the CasADi contestant.
"""


def best(rows: list[dict[str, Any]], ours: bool, key: str = "seconds_to_truth") -> float:
    """Return the least time to truth among haptid's rows or among the others."""
    found = [r[key] for r in rows if r["contestant"].startswith("haptid") == ours and r[key] is not None]
    return min(found, default=float("nan"))


def lines(title: str, rows: list[dict[str, Any]]) -> list[str]:
    """Return the table of one case, times as ratios too."""
    rival = best(rows, ours=False)
    shown = [
        title,
        f"{'':44s}{'reached':>9s}{'s/start':>9s}{'CPU s':>8s}{'to truth s':>12s}{'best rival ÷ it':>17s}",
    ]
    for row in rows:
        if not row["starts"]:
            shown.append(f"{row['contestant']:44s}  {row.get('failure', '')[-90:]}")
            continue
        share, truth = f"{row['reached']}/{len(row['starts'])}", row["seconds_to_truth"]
        spent = sum(s["seconds"] for s in row["starts"])
        told = f"{truth:12.2f}{rival / truth:17.2f}" if truth else f"{f'> {spent:.0f}':>12s}{'–':>17s}"
        shown.append(
            f"{row['contestant']:44s}{share:>9s}{row['seconds_per_start']:9.2f}{row['cpu_seconds_per_start']:8.2f}{told}"
        )
    return shown


def page(cases: dict[str, list[dict[str, Any]]], kept: dict[str, Any]) -> str:
    """Return the tables and what to know about them as Markdown."""
    tables = "\n\n".join("\n".join(lines(CASES[name].title, rows)) for name, rows in cases.items())
    made = f"`{kept['command']}`, {kept['date']}, {kept['machine']}, {kept['wall_s'] / 60:.0f} min."
    return f"# Time to truth\n\n{WHAT}\n\n{made}\n\n```text\n{tables}\n```\n{NOTES}"
