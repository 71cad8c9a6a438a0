"""URDF and MJCF of the identified six-joint device in MuJoCo and Pinocchio, beside haptid and the FMU.

1. Mass matrix and bias (C·v and gravity) at a thousand random states, against haptid's own.
2. Motions under the recorded torques of the embedded runs with all joints free, from the measured start and without
   feedback, against the native FMU of the same values in fmpy: with friction reduced to viscous friction, which both
   have, and with all friction.

Results go to ``docs/results/multibody.json`` and to the page on other simulators.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import click
import mujoco
import numpy as np
from fmpy.simulation import simulate_fmu

from benchmarks.simulators import page, whole
from benchmarks.simulators.in_bodies import Array, Motion, motion, mujoco_terms, own_terms, pinocchio_terms
from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.description.variables import structured_name
from haptid.fmu_build.multibody.bodies import Multibody
from haptid.fmu_build.multibody.mjcf import FrictionOf, mjcf_bytes
from haptid.fmu_build.multibody.write import identified_multibody, write_multibody
from haptid.fmu_build.native.platforms import this_platform
from haptid.measurement.values.run import Run
from haptid.support.files.files import write_json
from haptid.support.terminal import Count
from studies.ledger.version import origin_of

OUT = Path(__file__).parents[2] / "docs" / "results" / "multibody.json"
STATES = 1000
SOFT = 1e-9
"""Stiffness [N m/rad] and damping [N m s/rad] of a bristle that pulls at nothing."""
WAYS: tuple[tuple[str, FrictionOf, str, float], ...] = (
    ("viscous alone", "frictionloss", "RK4", 5e-4),
    ("LuGre", "lugre", "RK4", 5e-4),
    ("LuGre", "lugre", "RK4", 1e-4),
    ("LuGre", "lugre", "Euler", 5e-4),
    ("LuGre", "lugre", "implicitfast", 5e-4),
    ("frictionloss", "frictionloss", "RK4", 5e-4),
    ("frictionloss", "frictionloss", "implicitfast", 5e-4),
)
"""Friction of the MJCF, integrator and step [s] of each motion."""


def compare_terms(machine: Multibody, folder: Path) -> list[dict[str, Any]]:
    """Return the largest relative differences of mass matrix and bias over random states, by file and reader."""
    urdf = write_multibody(machine, folder / "device.urdf", "urdf").path
    mjcf = write_multibody(machine, folder / "device.xml", "mjcf").path
    models = {name: mujoco.MjModel.from_xml_path(str(path)) for name, path in (("URDF", urdf), ("MJCF", mjcf))}
    readers: dict[tuple[str, str], Callable[[Array, Array], tuple[Array, Array]]] = {
        ("URDF", "Pinocchio"): lambda q, v: pinocchio_terms(urdf, q, v),
        ("URDF", "MuJoCo"): lambda q, v: mujoco_terms(models["URDF"], machine, q, v),
        ("MJCF", "MuJoCo"): lambda q, v: mujoco_terms(models["MJCF"], machine, q, v),
    }
    rng = np.random.default_rng(0)
    states = rng.uniform(-1, 1, (STATES, 2, len(machine.axes))) * np.array([1.0, 3.0])[None, :, None]
    rows = []
    for (form, reader), terms in readers.items():
        worst = np.zeros(2)
        for q, v in Count(states, title=f"{form}, {reader}"):
            for k, (theirs, ours) in enumerate(zip(terms(q, v), own_terms(whole.device(), machine, q, v), strict=True)):
                worst[k] = max(worst[k], np.abs(theirs - ours).max() / np.abs(ours).max())
        rows.append({"file": form, "reader": reader, "mass_matrix": worst[0], "bias": worst[1]})
    return rows


def of_fmu(values: Mapping[str, float], run: Run, folder: Path) -> tuple[Array, Array]:
    """Return positions and control point of the native FMU along a run, from its measured start."""
    known = whole.equations()
    parameters = tuple(q.but(initial=values[q.id], lower=min(q.lower, values[q.id])) for q in known.parameters)
    made = replace(known, parameters=parameters)
    start = {f"q{j}": float(run.y[0, j]) for j in range(run.y.shape[1])}
    fmu = build_fmu(made, folder / "device.fmu", kind="native", values=start, platforms=this_platform())
    names = {part.id: structured_name(made, part.id, part.structured) for part in made.inputs}
    names |= {part.id: structured_name(made, part.id, part.structured) for part in made.outputs}
    signals = np.zeros(run.t.size, dtype=[("time", "f8"), *((names[part.id], "f8") for part in made.inputs)])
    signals["time"] = run.t
    for j in run.free_joints:
        signals[names[f"tau{j}"]] = run.u[:, j]
    wanted = [*(f"y{j}" for j in run.free_joints), "handle_x", "handle_y", "handle_z"]
    step = float(run.t[1] - run.t[0])
    found = simulate_fmu(
        str(fmu.path), input=signals, output=[names[id] for id in wanted], stop_time=float(run.t[-1]),
        output_interval=step, step_size=step, fmi_type="CoSimulation", use_event_mode=False,
    )  # fmt: skip
    rows = np.column_stack([found[names[id]] for id in wanted])[: run.t.size]
    return rows[:, :-3], rows[:, -3:]


def compare(moved: Motion, expected: tuple[Array, Array], noise: Array) -> dict[str, Any]:
    """Return RMS and largest difference of a motion in MuJoCo and in the FMU."""
    error = moved.positions - expected[0]
    rms = np.sqrt(np.mean(error**2, axis=0))
    return {
        "rms_rad": rms.tolist(),
        "rms_over_noise": (rms / noise).tolist(),
        "largest_rad": float(np.abs(error).max()),
        "largest_handle_m": float(np.abs(moved.handle - expected[1]).max()),
        "slip_rad": moved.slip,
    }


def compare_motions(machine: Multibody, folder: Path) -> list[dict[str, Any]]:
    """Return what each way leaves on each run."""
    values, rows = whole.values(), []
    viscous = replace(machine, axes=tuple(replace(axis, coulomb=0.0) for axis in machine.axes))
    for run in whole.runs():
        expected = {
            False: of_fmu(values, run, folder),
            True: of_fmu(whole.without_bristle(values, SOFT), run, folder),
        }
        for words, friction, integrator, step in Count(WAYS, title=run.file):
            alone = words == "viscous alone"
            text = mjcf_bytes(viscous if alone else machine, friction).decode()
            model = mujoco.MjModel.from_xml_string(text)
            model.opt.timestep = step
            model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
            begun = time.perf_counter()
            moved = motion(model, machine, run.t, run.u, run.y[0])
            wall = time.perf_counter() - begun
            rows.append(
                {"run": run.file, "friction": words, "integrator": integrator, "step_s": step,
                 "duration_s": float(run.t[-1]), "wall_s": wall, **compare(moved, expected[alone], run.noise)}
            )  # fmt: skip
    return rows


@click.command(help=__doc__)
@click.option("--page", "page_alone", is_flag=True, help="Write the page from the stored results.")
def main(page_alone: bool) -> None:
    """Compare, and write results and page."""
    if not page_alone:
        machine = identified_multibody(whole.device(), whole.result())
        with tempfile.TemporaryDirectory() as folder:
            terms, motions = compare_terms(machine, Path(folder)), compare_motions(machine, Path(folder))
        write_json(
            OUT,
            {
                **origin_of(" ".join(["python -m benchmarks.simulators.multibody", *sys.argv[1:]])),
                "mujoco": mujoco.__version__, "pinocchio": version("pin"), "fmpy": version("fmpy"),
                "states": STATES, "noise_rad": float(whole.runs()[0].noise[0]), "terms": terms, "motions": motions,
            },
        )  # fmt: skip
    page.write()


if __name__ == "__main__":
    main()
