"""How the search for missing effects grows with its catalogue: a quarter, half and all of its effects, in one run.

Three synthetic campaigns (nothing hidden, one effect of the catalogue, one outside it) are worked through with each
catalogue, which always holds the hidden effect. CPU time counts this process alone, kernels compiled beforehand.
Results go to ``docs/results``.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from haptid.discrepancy.finding.finding import Finding, find
from haptid.discrepancy.study.study import study_of
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import with_folder
from haptid.support.listener import ignore_progress
from studies.hidden.run import make_cases
from studies.ledger.version import origin_of, store, tell_origin

OUT = Path(__file__).parents[2] / "docs" / "results" / "search_growth.json"
KINDS = {"none": "", "single": "asymmetric_viscous", "unlisted": ""}
WORDS = {"none": "nothing", "single": "one effect of the catalogue", "unlisted": "an effect outside the catalogue"}
SHARES = (4, 2, 1)
SEED = 7


def part_of(catalogue: dict[str, Effect], every: int, kept: str) -> dict[str, Effect]:
    """Return every ``every``-th effect of the catalogue, and those of the id ``kept``."""
    ids = sorted({e.id for e in catalogue.values() if not e.random})
    chosen = {*ids[::every], kept, "amplitude_scatter"}
    return {key: e for key, e in catalogue.items() if e.id in chosen}


def searched(campaign: Path, effects: dict[str, Effect], out: Path) -> tuple[Finding, float]:
    """Return the finding and its CPU time [s], once kernels lie on disk."""
    read = campaign_for_command(str(campaign))
    for _ in range(2):
        began = time.process_time()
        found = find(
            study_of(read, read.joints[0], effects), out, kind="native", seed=0, starts=8, tell=ignore_progress
        )
        spent = time.process_time() - began
    return found, spent


def searches(kind: str, effect: str, folder: Path) -> Iterator[dict[str, Any]]:
    """Work through a campaign with each catalogue; give a row of the table as each is done."""
    catalogue = with_folder(None)
    make_cases(folder, 1, SEED, kinds=[kind], sizes=["nominal"], inputs="table3", effects=[effect] if effect else [])
    for every in SHARES:
        effects = part_of(catalogue, every, effect)
        found, spent = searched(folder / "cases" / "case_0000", effects, folder / "out")
        row = {
            "hidden": kind,
            "entries": len(effects),
            "simulations": found.search.simulations,
            "cpu_s": spent,
            "verdict": found.judgement.verdict,
        }
        click.echo(f"{WORDS[kind]}, {row['entries']} entries: {spent:.1f} s of processor, {row['verdict']}", err=True)
        yield row


def page(stored: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    lines = [
        "# How the search grows with its catalogue",
        "",
        "Synthetic campaigns, inputs of Table III of Tam, Kubica and Wang (2005), nominal size of the effect, one case "
        f"of each kind (seed {SEED}). Processor time of one process on one thread, kernels compiled before.",
        "",
        tell_origin(stored),
        "",
        "| hidden | entries | simulations of a run | processor [s] | over the smallest | verdict |",
        "| --- | ---: | ---: | ---: | ---: | --- |",
    ]
    ratios = []
    for kind, words in WORDS.items():
        rows = [row for row in stored["rows"] if row["hidden"] == kind]
        for row in rows:
            ratio = row["cpu_s"] / rows[0]["cpu_s"]
            lines.append(
                f"| {words} | {row['entries']} | {row['simulations']} | {row['cpu_s']:.1f} | {ratio:.2f} | "
                f"{row['verdict']} |"
            )
        ratios.append((rows[-1]["entries"] / rows[0]["entries"], rows[-1]["cpu_s"] / rows[0]["cpu_s"]))
    lines += [
        "",
        f"{min(r for r, _ in ratios):.1f} to {max(r for r, _ in ratios):.1f} times as many entries take "
        f"{min(t for _, t in ratios):.1f} to {max(t for _, t in ratios):.1f} times the time.",
    ]
    return "\n".join(lines) + "\n"


@click.command(help=__doc__)
def main() -> None:
    """Measure, and write results and page."""
    with tempfile.TemporaryDirectory() as folder:
        rows = [row for kind, effect in KINDS.items() for row in searches(kind, effect, Path(folder) / kind)]
    stored = {**origin_of("python -m benchmarks.search.search_growth"), "rows": rows}
    click.echo(store(OUT, stored, page))


if __name__ == "__main__":
    main()
