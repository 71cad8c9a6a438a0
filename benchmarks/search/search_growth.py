"""How the search for missing effects grows with its catalogue: a quarter, half and all of its effects, in one run.

Three synthetic campaigns (nothing hidden, one effect of the catalogue, one outside it) are worked through with each
catalogue, which always holds the hidden effect. CPU time counts this process alone, kernels compiled beforehand.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from haptid.discrepancy.finding.finding import Finding, find
from haptid.discrepancy.study.study import study_of
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import with_folder
from studies.hidden.run import make_cases

KINDS = {"none": "", "single": "asymmetric_viscous", "unlisted": ""}
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
            study_of(read, read.joints[0], effects), out, kind="native", seed=0, starts=8, tell=lambda _text: None
        )
        spent = time.process_time() - began
    return found, spent


def main() -> None:
    """Print effects, simulations, CPU time and its ratio to that of the smallest catalogue."""
    catalogue = with_folder(None)
    print(f"{'hidden':10s}{'entries':>9s}{'simulations':>13s}{'CPU':>8s}{'ratio':>7s}  verdict")
    with tempfile.TemporaryDirectory() as folder:
        for kind, effect in KINDS.items():
            place = Path(folder) / kind
            make_cases(
                place, 1, SEED, kinds=[kind], sizes=["nominal"], inputs="table3", effects=[effect] if effect else []
            )
            first = 0.0
            for every in SHARES:
                effects = part_of(catalogue, every, effect)
                found, spent = searched(place / "cases" / "case_0000", effects, place / "out")
                first = first or spent
                count, sums = len(effects), found.search.simulations
                print(
                    f"{kind:10s}{count:9d}{sums:13d}{spent:6.1f} s{spent / first:7.2f}  {found.judgement.verdict}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
