"""Draw the gallery: a posterior, a hidden effect that is found, an FMU in two other simulators, and real machines.

``python -m docs.from_runs.gallery`` runs the code of both tutorials, draws what they found, and stores the numbers;
``--tables`` writes the page's tables again from what is stored.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click
import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib import pyplot as plt

from docs.from_runs import python_api, tutorial_page
from docs.from_runs.pendulum_tables import FOLDER as TABLES
from docs.parts.tables import table, with_parts
from haptid import Missing, Posteriors
from haptid.report.common.style import ACCENT, MEASURED, RESIDUAL, SIMULATED, png, style
from haptid.support.files.files import write_bytes, write_json, write_text
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "gallery.md"
STORED = ROOT / "docs" / "results" / "gallery.json"
PICTURES = ROOT / "docs" / "images"
MACHINES = ROOT / "docs" / "results" / "real_machines.json"
SCRIPT = "docs/from_runs/gallery.py"
TRUTH = {
    "inertia": 0.012, "gravity_sin": 0.3, "Ks": 0.4, "sigma0": 30.0, "sigma2": 0.02, "Fs": 0.04, "Fc": 0.03, "vs": 0.2,
}  # fmt: skip
"""Numbers of the pendulum that the second tutorial simulates."""
STIFFENING = 0.1
"""What is hidden there [N m/rad³]."""
UNSEEN = "val_1.csv"


def draw_posterior(posteriors: Posteriors) -> bytes:
    """Return the marginal posteriors beside the truth."""
    mpl.use("agg")
    with style():
        made, axes = plt.subplots(2, 4, figsize=(11.0, 4.6), layout="constrained")
        for ax, (id, true) in zip(axes.flat, TRUTH.items(), strict=True):
            posteriors.plot_marginal(id, ax=ax)
            ax.axvline(true, color=ACCENT, linewidth=1.6, label="true")
            draws = posteriors.draws()[id]
            low, high = np.quantile(draws, (0.0005, 0.9995))
            ax.set_xlim(min(low, true), max(high, true))
            ax.locator_params(axis="x", nbins=3)
            ax.ticklabel_format(axis="x", useOffset=False)
            if ax.get_legend() is not None:
                ax.get_legend().remove()
        handles, labels = axes.flat[0].get_legend_handles_labels()
        made.legend(handles, labels, loc="outside lower center", ncols=3)
        return png(made)


def posterior_numbers(posteriors: Posteriors) -> dict[str, dict[str, Any]]:
    """Return median and 95 % interval of each parameter, with the truth."""
    rows = posteriors.summary().loc[0]
    return {
        id: {
            "true": true,
            "median": float(rows["median"][id]),
            "lower_95": float(rows.lower_95[id]),
            "upper_95": float(rows.upper_95[id]),
            "unit": str(rows.unit[id]),
        }
        for id, true in TRUTH.items()
    }


def draw_missing(missing: Missing) -> bytes:
    """Return what the model misses of an unseen run, before and after the search."""
    mpl.use("agg")
    with style():
        made, (above, below) = plt.subplots(2, 1, figsize=(9.0, 5.0), sharex=True, layout="constrained")
        missing.plot_fit(ax=above)
        missing.plot_residuals(ax=below)
        above.set_xlabel("")
        return png(made)


def missing_numbers(missing: Missing) -> dict[str, Any]:
    """Return the verdict, the effect's parameter and how much of the gap it closes."""
    found, gap = missing.effects.loc["cubic_spring", "k3"], missing.gap.loc["validate"]
    return {
        "sentence": missing.sentence,
        "verdict": missing.verdict,
        "k3": {"true": STIFFENING, "value": float(found.value), "std": float(found["std"]), "unit": str(found.unit)},
        "gap": {key: float(gap[key]) for key in ("before", "after", "noise")},
    }


def draw_elsewhere(folder: Path) -> tuple[bytes, dict[str, float]]:
    """Return the unseen run of the first tutorial as measured and as FMPy simulates it, with the errors' RMS [deg]."""
    measured = pd.read_csv(TABLES / UNSEEN, comment="#")
    t, angle = measured["Time (ms)"] * 1e-3, measured["Angle (deg)"]
    simulated = np.loadtxt(folder / "work" / "fmpy.csv")[: len(measured)]
    mpl.use("agg")
    with style():
        made, (above, below) = plt.subplots(
            2, 1, figsize=(9.0, 4.6), sharex=True, height_ratios=[2, 1], layout="constrained"
        )
        above.plot(t, angle, color=MEASURED, label="measured (unseen run)", linewidth=1.6)
        above.plot(t, simulated, color=SIMULATED, linestyle="--", label="the FMU in FMPy")
        above.set_ylabel("angle [deg]")
        above.legend()
        below.plot(t, angle - simulated, color=RESIDUAL, linewidth=0.6)
        below.set_ylabel("residual [deg]")
        below.set_xlabel("time [s]")
        picture = png(made)
    return picture, {"rms_deg": float(np.sqrt(np.mean((angle - simulated) ** 2)))}


def posterior_table(rows: Mapping[str, Mapping[str, Any]]) -> str:
    """Return true values beside medians and intervals."""
    cells = []
    for id, row in rows.items():
        holds = "yes" if row["lower_95"] <= row["true"] <= row["upper_95"] else "no"
        interval = f"{row['lower_95']:.7g} … {row['upper_95']:.7g}"
        cells.append((f"`{id}`", f"{row['true']:g}", f"{row['median']:.7g}", interval, row["unit"], holds))
    return table(("parameter", "true", "median", "95 % interval", "unit", "holds the truth"), cells)


def missing_text(stored: Mapping[str, Any]) -> str:
    """Return what was found, in words and numbers."""
    k3, gap = stored["k3"], stored["gap"]
    rows = [
        ("verdict", f"`{stored['verdict']}`"),
        ("sentence", stored["sentence"]),
        ("hidden, true", f"{k3['true']:g} {k3['unit']}"),
        ("found", f"{k3['value']:.4g} ± {k3['std']:.2g} {k3['unit']}"),
        ("RMS of the unseen run, before", f"{1e3 * gap['before']:.3f} mrad"),
        ("after", f"{1e3 * gap['after']:.3f} mrad"),
        ("noise of the sensor", f"{1e3 * gap['noise']:.3f} mrad"),
    ]
    return table(("what", "value"), rows)


def machines_text() -> str:
    """Return a section a real machine, from the stored results."""
    parts = []
    for one in json.loads(MACHINES.read_text(encoding="utf-8"))["sets"]:
        met = sum(bool(figure["met"]) for figure in one["figures"])
        parts.append(
            f"### {one['title']}\n\n"
            f"{met} of {len(one['figures'])} figures reach their aims. Published: {one['source'].rstrip('.')}.\n\n"
            f"![Signals of an unseen run of {one['title']}, measured and simulated](results/{one['picture']})"
        )
    return "\n\n".join(parts)


def with_tables(page: str, stored: Mapping[str, Any]) -> str:
    """Return the page with its generated parts made anew."""
    parts = {
        "posterior": posterior_table(stored["posterior"]),
        "hidden effect": missing_text(stored["missing"]),
        "elsewhere": f"What is left is {stored['elsewhere']['rms_deg']:.3f}° RMS; the noise that was added is 0.02°.",
        "real machines": machines_text(),
    }
    return with_parts(page, parts, SCRIPT)


def make() -> dict[str, Any]:
    """Run both tutorials, draw the pictures, and return the numbers."""
    with tempfile.TemporaryDirectory() as scratch:
        names = python_api.run_page(Path(scratch)).names
        write_bytes(PICTURES / "gallery_posterior.png", draw_posterior(names["posteriors"]))
        write_bytes(PICTURES / "gallery_missing.png", draw_missing(names["missing"]))
        stored: dict[str, Any] = {
            "date": datetime.now(UTC).date().isoformat(),
            "posterior": posterior_numbers(names["posteriors"]),
            "missing": missing_numbers(names["missing"]),
        }
    with tempfile.TemporaryDirectory() as scratch:
        tutorial_page.run_page(Path(scratch))
        picture, stored["elsewhere"] = draw_elsewhere(Path(scratch))
        write_bytes(PICTURES / "gallery_fmu.png", picture)
    return stored


@click.command()
@click.option("--tables", is_flag=True, help="Write the tables alone, from what is stored.")
def main(tables: bool) -> None:
    """Draw the gallery."""
    if not tables:
        write_json(STORED, make())
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    write_text(PAGE, with_tables(PAGE.read_text(encoding="utf-8"), stored))
    click.echo(PAGE.relative_to(ROOT))


if __name__ == "__main__":
    main()
