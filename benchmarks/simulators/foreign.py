"""Calibration of FMUs that are not ours: values, error bars and time, and the time per simulation beside ModestPy's.

Reference FMUs of the FMI project (FMI 2.0 and 3.0, one with events), FMUs by stock pythonfmu and pythonfmu3, two of
OpenModelica that gemseo-fmu's package carries, and two of JModelica.org that ModestPy's package carries. Each is
simulated by FMPy at stated values, white noise is added, and ``haptid identify`` starts from other values. SYNTHETIC.
The reference FMUs lie beside the checkout; ModestPy, pythonfmu3 and gemseo-fmu get environments of their own. Results
go to ``docs/results/foreign_fmus.json`` and to the page on foreign FMUs.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click
import fmpy
import numpy as np
import tomli_w
from fmpy.simulation import simulate_fmu
from pythonfmu import FmuBuilder

from benchmarks.peers.environments import MODESTPY, Environment, NotInstalled
from benchmarks.simulators import page
from haptid.identification.commands import identify
from haptid.support.files.files import write_json
from haptid.support.installing.environment import ROOT
from haptid.support.terminal import Count
from studies.ledger.version import origin_of

OUT = ROOT / "docs" / "results" / "foreign_fmus.json"
DATA = Path(os.environ.get("HAPTID_DATA", ROOT.parent / "shared" / "data")) / "foreign_fmus"
SLAVE = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

class Spring(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.force, self.x, self.v, self.stiffness, self.damping = 0.0, 0.0, 0.0, 10.0, 0.5
        self.register_variable(Real("force", causality=Fmi2Causality.input))
        self.register_variable(Real("x", causality=Fmi2Causality.output))
        for name in ("stiffness", "damping"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def do_step(self, current_time, step_size):
        for _ in range(20):
            self.v += step_size / 20 * (self.force - self.stiffness * self.x - self.damping * self.v)
            self.x += step_size / 20 * self.v
        return True
"""
"""A slave as users of pythonfmu write them."""
SLAVE3 = (
    SLAVE.replace("pythonfmu", "pythonfmu3").replace("Fmi2", "Fmi3").replace("Real", "Float64").replace(
        "        self.register",
        "        self.time = 0.0\n        self.register_variable(Float64('time', causality=Fmi3Causality.independent, "
        "variability=Fmi3Variability.continuous))\n        self.register",
        1,
    )
)  # fmt: skip
"""The same for FMI 3.0, whose variables include time."""
PYTHONFMU3 = Environment(name="pythonfmu3", requirements=("pythonfmu3==0.3.4",))
"""Environment of another generator, of FMI 3.0; what it builds brings its own code along."""

GEMSEO_FMU = Environment(name="gemseo_fmu", requirements=("--no-deps", "gemseo-fmu==3.1.1"))
"""Environment of a package that carries FMUs of OpenModelica; its own code is not run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """An FMU with what is hidden in its data.

    Parameters
    ----------
    title, generator
        Words for a reader.
    fmu
        The archive.
    truth
        Value by parameter.
    parameters
        Table of the campaign's ``[parameters]``.
    output, noise
        Observed output and standard deviation of its noise.
    end, rows
        Duration [s or the FMU's unit of time] and number of rows.
    inputs
        Column by input.
    starts
        Start values of the fitted and the validated run.
    """

    title: str
    generator: str
    fmu: Path
    truth: Mapping[str, float]
    parameters: Mapping[str, Mapping[str, float]]
    output: str
    noise: float
    end: float
    rows: int
    inputs: Mapping[str, Any] = field(default_factory=dict)
    starts: tuple[Mapping[str, float], Mapping[str, float]] = ({}, {})


def cases(folder: Path) -> Iterator[Case]:
    """Yield the FMUs that are there."""
    for version in ("fmi2", "fmi3"):
        words = f"Reference FMUs, FMI {version[-1]}.0"
        if not DATA.exists():
            break
        yield Case(
            title="Dahlquist", generator=words, fmu=DATA / version / "Dahlquist.fmu", truth={"k": 0.63},
            parameters={"k": {"initial": 1.0, "lower": 0.1, "upper": 5.0}}, output="x", noise=0.005, end=4.0, rows=41,
            starts=({"x": 2.0}, {"x": 1.0}),
        )  # fmt: skip
        yield Case(
            title="BouncingBall, with events", generator=words, fmu=DATA / version / "BouncingBall.fmu",
            truth={"g": -9.3, "e": 0.82}, output="h", noise=0.01, end=2.0, rows=201,
            parameters={
                "g": {"initial": -9.81, "lower": -12.0, "upper": -7.0},
                "e": {"initial": 0.7, "lower": 0.5, "upper": 1.0},
            },
            starts=({}, {"h": 1.5}),
        )  # fmt: skip
    t = np.linspace(0.0, 10.0, 201)
    for generator, fmu in _springs(folder):
        yield Case(
            title="a spring with damping", generator=generator, fmu=fmu, output="x", noise=0.002,
            truth={"stiffness": 14.0, "damping": 0.8}, end=10.0, rows=201, inputs={"force": np.cos(2 * t) + (t > 5)},
            parameters={
                "stiffness": {"initial": 10.0, "lower": 1.0, "upper": 100.0},
                "damping": {"initial": 0.5, "lower": 0.01, "upper": 10.0},
            },
        )  # fmt: skip
    yield from _of_openmodelica()
    yield from _of_modestpy()


def _springs(folder: Path) -> Iterator[tuple[str, Path]]:
    """Build the spring by both generators."""
    script = folder / "spring.py"
    script.write_text(SLAVE, encoding="utf-8")
    yield "pythonfmu", Path(FmuBuilder.build_FMU(script, dest=folder))
    script3 = folder / "spring3.py"
    script3.write_text(SLAVE3, encoding="utf-8")
    code = (
        f"from pythonfmu3 import FmuBuilder; print(FmuBuilder.build_FMU({str(script3)!r}, dest={str(folder / 'v3')!r}))"
    )
    try:
        done = subprocess.run([PYTHONFMU3.ready(), "-c", code], capture_output=True, text=True, check=True)
    except (NotInstalled, subprocess.CalledProcessError) as reason:
        click.echo(f"pythonfmu3: {reason}", err=True)
        return
    yield "pythonfmu3", Path(done.stdout.strip().splitlines()[-1])


def _of_openmodelica() -> Iterator[Case]:
    try:
        place = next(GEMSEO_FMU.ready().parents[1].rglob("gemseo_fmu/problems/fmu_files/linux"))
    except (NotInstalled, StopIteration) as reason:
        click.echo(f"gemseo-fmu: {reason}", err=True)
        return
    words, t = "OpenModelica {}, in gemseo-fmu's package", np.linspace(0.0, 4.0, 401)
    yield Case(
        title="Mass_Damper", generator=words.format("1.19.3"), fmu=place / "Mass_Damper.fmu", output="y", noise=1e-4,
        truth={"damper.d": 1.4, "mass.m": 1.3, "spring.c": 80.0}, end=4.0, rows=401,
        inputs={"f": np.sin(5 * t) + (t > 2)},
        parameters={
            "damper.d": {"initial": 2.0, "lower": 0.2, "upper": 20.0},
            "mass.m": {"initial": 2.0, "lower": 0.2, "upper": 20.0},
            "spring.c": {"initial": 50.0, "lower": 5.0, "upper": 500.0},
        },
    )  # fmt: skip
    yield Case(
        title="ramp, with events", generator=words.format("1.20.0"), fmu=place / "ramp.fmu", output="out", noise=0.01,
        truth={"ramp.height": 3.0, "ramp.duration": 1.7, "ramp.startTime": 0.8}, end=5.0, rows=101,
        parameters={
            "ramp.height": {"initial": 2.0, "lower": 0.1, "upper": 20.0},
            "ramp.duration": {"initial": 1.0, "lower": 0.1, "upper": 4.0},
            "ramp.startTime": {"initial": 0.5, "lower": 0.0, "upper": 3.0},
        },
    )  # fmt: skip


def _of_modestpy() -> Iterator[Case]:
    try:
        place = next(MODESTPY.ready().parents[1].rglob("modestpy/test/resources"))
    except (NotInstalled, StopIteration) as reason:
        click.echo(f"ModestPy: {reason}", err=True)
        return
    hours = np.linspace(0.0, 86400.0, 145)
    outside = 273.15 + 10 * np.sin(2 * np.pi * hours / 86400)
    for name in ("simple2R1C", "simple2R1C_ic"):
        title = name[0].upper() + name[1:]
        yield Case(
            title=title, generator="JModelica.org, in ModestPy's package", fmu=place / name / f"{title}_linux64.fmu",
            truth={"R1": 0.1, "R2": 0.25, "C": 2000.0}, output="T", noise=0.05, end=86400.0, rows=145,
            inputs={"Ti1": outside, "Ti2": 293.15 + (hours > 30000)},
            parameters={
                "R1": {"initial": 0.08, "lower": 0.001, "upper": 0.5},
                "R2": {"initial": 0.08, "lower": 0.001, "upper": 0.5},
                "C": {"initial": 1000.0, "lower": 500.0, "upper": 10000.0},
            },
        )  # fmt: skip


def write_campaign(case: Case, folder: Path) -> Path:
    """Simulate the case at its hidden values by FMPy and write the campaign."""
    folder.mkdir(parents=True)
    shutil.copy(case.fmu, folder / "model.fmu")
    t, runs = np.linspace(0.0, case.end, case.rows), []
    for seed, (file, start) in enumerate(zip(("a.csv", "b.csv"), case.starts, strict=True)):
        inputs = {name: np.asarray(x, dtype=float) for name, x in case.inputs.items()}
        rng = np.random.default_rng(seed)
        x = _held(case, inputs, t, start) + case.noise * rng.standard_normal(t.size)
        header = ",".join(["time_s", *(f"in_{name}" for name in inputs), "measured"])
        np.savetxt(folder / file, np.column_stack([t, *inputs.values(), x]), delimiter=",", header=header, comments="")
        runs.append({"file": file, "use": "fit" if seed == 0 else "validate", "start": dict(start)})
    campaign = {
        "campaign": {"title": case.title, "measured": False, "model": "model.fmu", "hold": "zero"},
        "inputs": {name: {"column": f"in_{name}"} for name in case.inputs},
        "outputs": {case.output: {"column": "measured", "noise": case.noise}},
        "parameters": {name: dict(one) for name, one in case.parameters.items()},
        "runs": runs,
    }
    (folder / "campaign.toml").write_text(tomli_w.dumps(campaign), encoding="utf-8")
    return folder


def _held(case: Case, inputs: Mapping[str, Any], t: Any, start: Mapping[str, float]) -> Any:
    """Simulate with inputs held between rows."""
    signals = None
    if inputs:
        signals = np.zeros(t.size, dtype=[("time", "f8"), *((name, "f8") for name in inputs)])
        signals["time"] = t
        for name, values in inputs.items():
            signals[name] = values
    found = simulate_fmu(
        str(case.fmu), start_values={**case.truth, **start}, input=signals, output=[case.output],
        stop_time=float(t[-1]), output_interval=float(t[1]), step_size=float(t[1]), fmi_type="CoSimulation",
        record_events=False,
        use_event_mode=False,
    )  # fmt: skip
    return found[case.output][: t.size]


def calibrate(case: Case, folder: Path) -> dict[str, Any]:
    """Calibrate an FMU by the command and return what came of it."""
    about = {"title": case.title, "generator": case.generator, "fmi": fmpy.read_model_description(case.fmu).fmiVersion}
    try:
        campaign = write_campaign(case, folder / "campaign")
    except Exception as error:  # FMPy raises bare exceptions where a binary does not load
        return about | {"failed": str(error).partition(". ")[2] or str(error)}
    out = folder / "out"
    arguments = [str(campaign), "--out", str(out), "--quiet", "--workers", "1"]
    begun = time.perf_counter()
    try:
        identify(arguments, standalone_mode=False)
    except (SystemExit, click.ClickException) as error:
        if getattr(error, "code", 1):
            return about | {"failed": f"haptid identify ends with {error}"}
    wall = time.perf_counter() - begun
    (one,) = json.loads((out / "identification.json").read_text(encoding="utf-8"))["configurations"]
    found = {
        name: {"truth": truth, "value": one["parameters"][name]["value"], "std": one["parameters"][name]["std"]}
        for name, truth in case.truth.items()
    }
    validated = [run["rmse_over_noise"][case.output] for run in one["runs"] if run["use"] == "validate"]
    return about | {
        "outcome": one["outcome"], "parameters": found, "simulations": one["simulations"], "wall_s": wall,
        "simulation_s": one["simulation_s"],
        "rows": case.rows, "validate_over_noise": max(validated),
    }  # fmt: skip


MODESTPY_SCRIPT = """
import json, sys, time, logging
import numpy as np, pandas as pd
from modestpy.fmi.model import Model
logging.disable(logging.CRITICAL)
fmu, table, output, truth = sys.argv[1], sys.argv[2], sys.argv[3], json.loads(sys.argv[4])
data = pd.read_csv(table).rename(columns={"time_s": "time"}).set_index("time")
model = Model(fmu)
inputs = data[[c for c in data if c.startswith("in_")]].rename(columns=lambda c: c[3:])
model.inputs_from_df(inputs)
model.specify_outputs([output])
model.parameters_from_df(pd.DataFrame({k: [v] for k, v in truth.items()}))
model.simulate()
begun, n = time.perf_counter(), 20
for _ in range(n):
    model.simulate()
print("SECONDS", (time.perf_counter() - begun) / n)
"""


def seconds_of_modestpy(case: Case, campaign: Path) -> float | None:
    """Return ModestPy's time for one simulation of the fitted run [s]; None where it does not simulate the FMU."""
    done = subprocess.run(
        [MODESTPY.ready(), "-c", MODESTPY_SCRIPT, case.fmu, campaign / "a.csv", case.output,
         json.dumps(dict(case.truth))],
        capture_output=True, text=True, check=False, timeout=300, cwd=campaign,  # it leaves a file where it is called
    )  # fmt: skip
    found = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("SECONDS")]
    if not found:
        click.echo(f"ModestPy, {case.title}: {done.stderr.strip()[-200:]}", err=True)
    return float(found[0]) if found else None


@click.command(help=__doc__)
@click.option("--page", "page_alone", is_flag=True, help="Write the page from the stored results.")
def main(page_alone: bool) -> None:
    """Calibrate all FMUs, and write results and page."""
    if not page_alone:
        rows = []
        with tempfile.TemporaryDirectory() as folder:
            for number, case in enumerate(Count(list(cases(Path(folder))), title="FMUs")):
                place = Path(folder) / str(number)
                row = calibrate(case, place)
                if row["fmi"].startswith("2") and case.inputs and "failed" not in row:  # what ModestPy takes
                    row["modestpy_s"] = seconds_of_modestpy(case, place / "campaign")
                rows.append(row)
        write_json(
            OUT,
            {
                **origin_of(" ".join(["python -m benchmarks.simulators.foreign", *sys.argv[1:]])),
                "modestpy": MODESTPY.requirements[0], "rows": rows,
            },
        )  # fmt: skip
    page.write()


if __name__ == "__main__":
    main()
