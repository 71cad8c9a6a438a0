"""Time to truth: seconds per start over the share of starts that reach the noise on a run that no fit saw.

The problem is stated in `benchmarks.peers.problem`. Contestants run one after the other, each in its own process with
one thread, from the same first starts. Without ``--peers`` only haptid and fmpy run; with it also the tools that need
environments of their own, made below ``.cache/peers``, and the results go to ``docs/results/time_to_truth.json``.
``--again haptid,CasADi`` runs those side by side anew and keeps the other lines of the stored results.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks.peers.environments import AMICI, CACHE, CASADI, MODESTPY, ROOT, Environment, NotInstalled
from benchmarks.peers.problem import CASES, NAMES, THRESHOLD, Case
from benchmarks.peers.table import lines, page, ratios
from haptid.fmu_build.building.packaging import build_fmu
from haptid.model.joint.locked_joint import joint_equations
from studies.ledger.version import origin_of

OUT = ROOT / "docs" / "results" / "time_to_truth.json"
MOST_STARTS = 16
SINGLE = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Contestant:
    """A script of `benchmarks.peers`, how it is called, and how many starts it gets within which budget [s] each."""

    label: str
    module: str
    count: int
    budget: float
    variant: str = ""
    environment: Environment | None = None


WAYS = {"Python FMU": "python", "native FMU": "native", "kernel": "kernel"}
METHODS = {"SLSQP": "slsqp", "Gauss-Newton": "gauss_newton"}
CONTESTANTS = (
    *(
        Contestant(label=f"haptid, {way}, {m}", module="haptid_fit", variant=f"{w}:{method}", count=16, budget=30)
        for m, method in METHODS.items()
        for way, w in WAYS.items()
    ),
    Contestant(label="fmpy + SLSQP, finite differences", module="fmpy_slsqp", count=3, budget=45),
    *(
        Contestant(
            label=f"CasADi single shooting, {n} steps/row",
            module="casadi_single",
            variant=n,
            count=8,
            budget=30,
            environment=CASADI,
        )
        for n in ("1", "2", "4")
    ),
    Contestant(label="ModestPy SLSQP", module="modestpy_slsqp", count=2, budget=60, environment=MODESTPY),
    Contestant(label="AMICI forward sensitivities, TRF", module="amici_trf", count=8, budget=45, environment=AMICI),
)


def build_model(case: Case, path: Path) -> None:
    """Build the native FMU for peers: as shipped, but without the order of Fs and Fc, which they cannot keep."""
    values = {id: {"initial": value} for id, value in zip(NAMES, case.truth, strict=True)}
    build_fmu(replace(joint_equations(0), orderings=()).with_parameters(values), path, kind="native")


def run(contestant: Contestant, folder: Path) -> dict[str, Any]:
    """Let a contestant run on the statement in ``folder`` and return what it wrote, or why there is nothing."""
    try:
        python = contestant.environment.ready() if contestant.environment else Path(sys.executable)
    except NotInstalled as reason:
        return {"starts": [], "failure": f"did not install: {reason}"}
    out = folder / f"{contestant.module}_{contestant.variant.replace(':', '_')}.json"
    out.unlink(missing_ok=True)
    command = [
        str(python), "-m", f"benchmarks.peers.{contestant.module}", str(folder / "statement.json"), str(out),
        "--budget", str(contestant.budget), "--count", str(contestant.count), "--variant", contestant.variant,
    ]  # fmt: skip
    environment = {**os.environ, **SINGLE, "PATH": f"{python.parent}{os.pathsep}{os.environ['PATH']}"}
    limit = contestant.budget * (contestant.count + 4)
    try:
        done = subprocess.run(
            command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=limit, check=False
        )
        failure = done.stderr.strip()[-300:] if done.returncode else ""
    except subprocess.TimeoutExpired:
        failure = f"stopped after {limit:.0f} s"
    result = json.loads(out.read_text(encoding="utf-8")) if out.exists() else {"starts": []}
    return {**result, **({"failure": failure} if failure else {})}


def judged(contestant: Contestant, case: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Add what the judge says: RMS over noise of each start, how many reached it, seconds per start over that share."""
    for start in result["starts"]:
        theta = start["theta"]
        for name in ("fit", "validate"):
            start[f"{name}_rmse_over_noise"] = _finite(case.judge(None if theta is None else np.array(theta), name))
    scores = [s["validate_rmse_over_noise"] for s in result["starts"]]
    reached = [score is not None and score <= THRESHOLD for score in scores]
    row: dict[str, Any] = {
        "contestant": contestant.label,
        "budget_s": contestant.budget,
        "reached": sum(reached),
        **result,
    }
    for name in ("seconds", "cpu_seconds"):
        total = sum(s[name] for s in result["starts"])
        row[f"{name}_per_start"] = total / len(reached) if reached else None
        row[f"{name}_to_truth"] = total / sum(reached) if any(reached) else None
    return row


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def measure(name: str, chosen: list[Contestant]) -> list[dict[str, Any]]:
    """Run the contestants on a case, showing each on stderr."""
    case, folder = CASES[name], CACHE / "problem" / name
    case.write(folder / "statement.json", MOST_STARTS)
    build_model(case, folder / "model.fmu")
    rows = []
    for contestant in chosen:
        click.echo(f"{name}: {contestant.label} (load {os.getloadavg()[0]:.1f})", err=True)
        before = os.getloadavg()[0]
        row = judged(contestant, case, run(contestant, folder))
        rows.append(row | {"load_before": before, "load_after": os.getloadavg()[0]})
    return rows


def earlier(name: str, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the stored lines of the contestants that were not run anew, marked as of another run."""
    known = {c.label for c in CONTESTANTS} - {row["contestant"] for row in rows}
    stored = json.loads(OUT.read_text(encoding="utf-8"))
    old = stored["cases"][name]["contestants"]
    return [{"of_run": stored["date"], **row} for row in old if row["contestant"] in known]


@click.command()
@click.option(
    "--peers", is_flag=True, help="Also the tools with environments of their own (installs them), and keep the results."
)
@click.option("--only", default="", help="Only contestants whose name holds this text; nothing is kept.")
@click.option("--again", default="", metavar="TEXT,...", help="With --peers: only these anew, the others' lines stay.")
def main(peers: bool, only: str, again: str) -> None:
    """Measure time to truth on the stated problem."""
    began = time.perf_counter()
    chosen = [c for c in CONTESTANTS if (peers or c.environment is None) and only in c.label]
    chosen = [c for c in chosen if any(text in c.label for text in again.split(","))]
    cases = {name: measure(name, chosen) for name in CASES}
    cases = {name: rows + (earlier(name, rows) if again else []) for name, rows in cases.items()}
    for name, rows in cases.items():
        click.echo("\n".join(lines(CASES[name].title, rows)) + "\n")
    if peers and not only:
        kept = {
            **origin_of("python -m benchmarks.time_to_truth --peers" + (f" --again {again}" if again else "")),
            "wall_s": time.perf_counter() - began,
            "threshold": THRESHOLD,
            "cases": {name: {"title": CASES[name].title, "contestants": rows} for name, rows in cases.items()},
            "best_rival_over_haptid": {name: ratios(rows) for name, rows in cases.items()},
        }  # fmt: skip
        OUT.parent.mkdir(parents=True, exist_ok=True)
        OUT.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        OUT.with_suffix(".md").write_text(page(cases, kept), encoding="utf-8")


if __name__ == "__main__":
    main()
