"""Cost of one 0.5 ms step of joint 4: native and Python FMU through the compiled loop, a hand-written C loop, fmpy.

Processor time over interleaved repeats, in ns per step: of one joint the shortest, which other work on the machine
does not lengthen, else medians; then sensitivities, lanes and the whole device. One joint's figures go to
``docs/results/fmu_speed.json`` and to the page on FMUs.
"""

from __future__ import annotations

import ctypes
import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from fmpy.simulation import simulate_fmu

from benchmarks.simulators import page
from haptid.fmu_build.building.cached import identification_fmu
from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.native.c_source import SCALAR_FLAGS
from haptid.fmu_build.native.platforms import this_platform
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.fmu_slave import FmuSlave
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Run
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.kernel.compiler import compile_shared
from haptid.support.files.files import write_json
from studies.ledger.version import origin_of

ROWS, STEP, REPEATS, AIM = 20_000, 5e-4, 9, 0.85
MANY_REPEATS = 50
OUT = Path(__file__).parents[2] / "docs" / "results" / "fmu_speed.json"
DEVICE = load_device("freedom6s")
T = STEP * np.arange(ROWS, dtype=float)
U = 5e-3 * np.cos(2 * T)[:, None]


def measure(calls: dict[str, Callable[[], object]], steps: int, repeats: int) -> dict[str, list[float]]:
    """Measure nanoseconds of processor time per step and repeat, in turn: so all calls see the same machine."""
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            start = time.thread_time()
            call()
            times[name].append((time.thread_time() - start) / steps * 1e9)
    return {name: t[1:] for name, t in times.items()}


def medians(calls: dict[str, Callable[[], object]], steps: int, repeats: int = REPEATS) -> dict[str, float]:
    """Return the median of `measure` of each call."""
    return {name: statistics.median(t) for name, t in measure(calls, steps, repeats).items()}


def by_hand(p: np.ndarray) -> Callable[[], np.ndarray]:
    """Compile the hand-written loop for the same target with the same flags as the FMU."""
    text = (Path(__file__).parent / "fmu_hand_written.c").read_text()
    compiled = compile_shared({"h.c": text}, main=("h.c",), triple=this_platform()[0].triple, flags=SCALAR_FLAGS)
    library = ctypes.CDLL(str(compiled))
    pointer = ctypes.c_void_p
    library.by_hand.argtypes = [ctypes.c_long, ctypes.c_double, pointer, pointer, pointer, pointer]

    def run() -> np.ndarray:
        x, y = np.zeros(3), np.empty(ROWS)
        library.by_hand(ROWS, STEP, U.ctypes.data, p.ctypes.data, x.ctypes.data, y.ctypes.data)
        return y

    return run


def joint(folder: Path) -> dict[str, object]:
    """One joint: the two packagings, by hand, by fmpy; what is stored of it."""
    e = configuration_equations(DEVICE, [4])
    p, kernel = np.array([q.initial for q in e.parameters]), CompiledKernel.of(e)
    slaves = {}
    for kind in ("native", "python"):
        built = build_fmu(e, folder / f"{kind}.fmu", kind=kind, platforms=this_platform())
        slaves[kind] = (FmuSlave(built.path), built)
    signals = np.zeros(ROWS, dtype=[("time", "f8"), ("joint4.torque", "f8")])
    signals["time"], signals["joint4.torque"] = T, U[:, 0]

    def loop(kind: str) -> np.ndarray:
        slave = slaves[kind][0]
        slave.initialise({})
        return slave.run(T, [slave.references["joint4.torque"]], U, [slave.references["joint4.reading"]])[:, 0]

    def fmpy_run(kind: str) -> object:
        return simulate_fmu(
            str(slaves[kind][1].path), input=signals, output=["joint4.reading"], stop_time=T[-1], output_interval=STEP
        )

    hand = by_hand(p)
    reference = kernel.simulate(T, U, p, np.zeros(3))[:, 0]
    for name, y in (("hand-written", hand()), ("native", loop("native")), ("python", loop("python"))):
        print(f"  largest difference of {name} from the kernel: {np.abs(y - reference).max():.1e} rad")
    times = measure(
        {
            "hand-written C loop": hand,
            "kernel in process (this machine's instructions)": lambda: kernel.simulate(T, U, p, np.zeros(3)),
            "native FMU, compiled loop": lambda: loop("native"),
            "Python FMU, compiled loop": lambda: loop("python"),
        },
        ROWS,
        MANY_REPEATS,
    )
    ns = {name: min(t) for name, t in times.items()}
    ns |= medians({f"fmpy.simulate_fmu, {kind}": partial(fmpy_run, kind) for kind in slaves}, ROWS, 3)
    for name, value in ns.items():
        print(f"  {name:50s}{value:10.0f} ns/step")
    native, hand_ns = ns["native FMU, compiled loop"], ns["hand-written C loop"]
    pairs = zip(times["hand-written C loop"], times["native FMU, compiled loop"], strict=True)
    each = statistics.median(theirs / ours for theirs, ours in pairs)
    print(f"  speed of the native FMU over the hand-written loop: {hand_ns / native:.2f}, {each:.2f} in the median of")
    print(f"    {MANY_REPEATS - 1} pairs (aim {AIM})")
    print(f"  Python FMU above its kernel: {(ns['Python FMU, compiled loop'] - native) / 1e3:.2f} us/step (aim 5)")
    return {
        "ns_per_step": {name: round(value, 1) for name, value in ns.items()},
        "step_s": STEP,
        "repeats": MANY_REPEATS - 1,
        "speed_over_by_hand": round(hand_ns / native, 3),
        "speed_over_by_hand_median": round(each, 3),
    }


def identification() -> None:
    """Time what a fit sees: trajectories of a run of 16 s with 5 ms rows."""
    e = configuration_equations(DEVICE, [4])
    t = 5e-3 * np.arange(3201, dtype=float)
    run = Run(
        file="run", free_joints=(4,), t=t, u=5e-3 * np.cos(2 * t)[:, None], y=0.1 * np.sin(t)[:, None],
        noise=np.array([2e-4]), resolution=np.zeros(1), posture=np.zeros(6), use="fit",
    )  # fmt: skip
    theta, inner = np.array([q.initial for q in e.parameters]), 10 * t.size
    kernel = KernelSimulator.of(e)
    calls: dict[str, Callable[[], object]] = {
        "kernel": lambda: kernel.simulate(theta, run),
        "kernel, sensitivities": lambda: kernel.simulate(theta, run, sensitivities=True),
    }
    for kind in ("native", "python"):
        fmu = FmuSimulator.of(identification_fmu(e, kind=kind), e)
        calls[f"{kind} FMU"] = partial(fmu.simulate, theta, run)
        calls[f"{kind} FMU, sensitivities"] = partial(fmu.simulate, theta, run, sensitivities=True)
    ns = medians(calls, inner)
    for name, value in ns.items():
        print(f"  {name:50s}{value * inner / 1e6:10.2f} ms/run")
    columns = len(e.parameters) + len(e.states)
    for name in ("kernel", "native FMU", "python FMU"):
        cost = ns[f"{name}, sensitivities"] / ns[name]
        print(f"  {columns} sensitivities, {name}: {cost:.2f} times the plain run (aim 5)")
    many, sets = np.tile(theta, (64, 1)), 64
    lanes = medians({"lanes": lambda: kernel.simulate_many(many, run)}, inner * sets, 5)["lanes"]
    print(f"  runs per second and core, lanes over scalar: {ns['kernel'] / lanes:.2f} (aim 2.5)")


def whole_device(folder: Path) -> None:
    """All six joints at 0.5 ms."""
    e = full_equations(DEVICE)
    rows = 4000
    u = np.zeros((rows, len(e.inputs)))
    u[:, :6] = 1e-2 * np.cos(2 * T[:rows])[:, None]
    calls: dict[str, Callable[[], object]] = {}
    for kind in ("native", "python"):
        slave = FmuSlave(build_fmu(e, folder / f"whole_{kind}.fmu", kind=kind, platforms=this_platform()).path)
        inputs = [slave.references[f"joint{j}.torque"] for j in range(6)]
        outputs = [slave.references[f"joint{j}.reading"] for j in range(6)]

        def run(slave: FmuSlave = slave, inputs: list[int] = inputs, outputs: list[int] = outputs) -> None:
            slave.initialise({})
            slave.run(T[:rows], inputs, u[:, :6], outputs)

        calls[kind] = run
    for kind, ns in medians(calls, rows).items():
        print(
            f"  6-DOF, {kind} FMU: {ns / 1e3:.2f} us/step, {STEP * 1e9 / ns:.0f} times faster than real time (aim 100)"
        )


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        print("one joint, 0.5 ms communication step")
        stored = joint(Path(name))
        print("identification, 16 s at 5 ms")
        identification()
        print("whole device, 0.5 ms communication step")
        whole_device(Path(name))
    about = {
        **origin_of("python -m benchmarks.models.fmu_speed"),
    }
    write_json(OUT, {**about, **stored})
    page.write()


if __name__ == "__main__":
    main()
