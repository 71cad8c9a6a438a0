"""What an FMU weighs, how long it builds cold and cached, whether two builds are the same bytes, how far all agree.

Agreement: joint 4 at 100 random points of its box, a cosine held over 5 ms rows for 2 s: both FMUs, the kernel, and
SciPy's Radau at 1e-10 on the equation written by hand.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.native.platforms import PLATFORMS, this_platform
from haptid.identification.simulators.fmu_slave import FmuSlave
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel

DEVICE = load_device("freedom6s")
POINTS = 100


def builds(folder: Path) -> None:
    """Sizes, seconds and bytes."""
    os.environ["HAPTID_CACHE"] = str(folder / "cache")
    for e in (configuration_equations(DEVICE, [4]), configuration_equations(DEVICE, [0, 1]), full_equations(DEVICE)):
        for kind in ("python", "native"):
            seconds, contents = [], []
            for _ in range(2):
                start = time.perf_counter()
                built = build_fmu(e, folder / f"{e.name}_{kind}.fmu", kind=kind, platforms=PLATFORMS)
                seconds.append(time.perf_counter() - start)
                contents.append(built.path.read_bytes())
            same = "same bytes" if contents[0] == contents[1] else "DIFFERENT BYTES"
            size = len(contents[0]) / 1024
            print(
                f"  {e.name:12s}{kind:8s}{size:6.0f} kB  cold {seconds[0]:6.1f} s  cached {seconds[1]:5.2f} s  {same}"
            )


def radau(p: dict[str, float], t: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Positions at the rows, the torque held in between, by an implicit method on the equation written by hand."""

    def f(_: float, x: np.ndarray, torque: float) -> list[float]:
        q, v, z = x
        g = p["Fc"] + (p["Fs"] - p["Fc"]) * np.exp(-((v / p["vs"]) ** 2))
        dz = v - p["sigma0"] * abs(v) / g * z
        load = p["gravity_cos"] * np.cos(q) + p["gravity_sin"] * np.sin(q) + p["Ks"] * (q - p["epos"])
        friction = p["sigma0"] * z + p["sigma1"] * dz + p["sigma2"] * v
        return [v, (p["Kp"] * torque - load - friction) / p["inertia"], dz]

    x, rows = np.zeros(3), [0.0]
    for k in range(t.size - 1):
        x = solve_ivp(f, (t[k], t[k + 1]), x, method="Radau", rtol=1e-10, atol=1e-12, args=(u[k],)).y[:, -1]
        rows.append(x[0])
    return np.array(rows)


def agreement(folder: Path) -> None:
    """Largest differences over random points."""
    e = configuration_equations(DEVICE, [4])
    kernel, rng, t = CompiledKernel.of(e), np.random.default_rng(0), 5e-3 * np.arange(401, dtype=float)
    u = 5e-3 * np.cos(2 * t)
    slaves = {
        kind: FmuSlave(build_fmu(e, folder / f"a_{kind}.fmu", kind=kind, platforms=this_platform()).path)
        for kind in ("python", "native")
    }
    worst = dict.fromkeys((*slaves, "radau", "fine"), 0.0)
    rms = []
    for point in range(POINTS):
        p = {q.id: q.initial if q.fixed else rng.uniform(q.lower, q.upper) for q in e.parameters}
        p["Fs"], p["Fc"] = max(p["Fs"], p["Fc"]), min(p["Fs"], p["Fc"])
        y = kernel.simulate(t, u[:, None], list(p.values()), np.zeros(3))[:, 0]
        for kind, slave in slaves.items():
            names = {q.id: f"joint4.{q.structured}" for q in e.parameters}
            slave.initialise({slave.references[names[id]]: value for id, value in p.items()})
            references = [slave.references[name] for name in ("joint4.torque", "joint4.reading")]
            got = slave.run(t, references[:1], u[:, None], references[1:])[:, 0]
            worst[kind] = max(worst[kind], float(np.abs(got - y).max()))
        if point < POINTS // 4:
            truth = radau(p, t, u)
            fine = kernel.simulate(t, u[:, None], list(p.values()), np.zeros(3), step=2e-5)[:, 0]
            rms.append(np.sqrt(np.mean((truth - y) ** 2)))
            worst["radau"] = max(worst["radau"], float(np.abs(truth - y).max()))
            worst["fine"] = max(worst["fine"], float(np.abs(truth - fine).max()))
    for kind in slaves:
        print(f"  {kind} FMU from the kernel, {POINTS} points: at most {worst[kind]:.1e} rad")
    print(
        f"  kernel from Radau, {len(rms)} points: at most {worst['radau']:.1e} rad, "
        f"RMS {np.median(rms):.1e} in the median, {max(rms):.1e} at worst; "
        f"with steps of 20 us at most {worst['fine']:.1e} rad"
    )


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        print("agreement of joint 4")
        agreement(Path(name))
        print("archives for five platforms")
        builds(Path(name))


if __name__ == "__main__":
    main()
