"""Forward dynamics of six joints: the tape as C with a 6×6 Cholesky solve, against Pinocchio's ABA on the same arm.

Prints the seconds of the exact derivation, the operations of the tape, and ns per call; then ns per evaluation of the
whole device's right-hand side as its FMU holds it, friction, springs and gains in it, parameters settable (a fourth of
a Runge-Kutta step, outputs included). Pinocchio runs from Python, and the overhead of that is measured apart with an
empty model.
"""

from __future__ import annotations

import ctypes
import dataclasses
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import sympy as sp

from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.rigid_body.base_parameters import full_lagrangian
from haptid.model.rigid_body.forward_dynamics import forward_dynamics
from haptid.model.rigid_body.inertial_parameters import standard_initial

SOLVE = """
static void solve(double A[N][N], double *b) {
  for (int j = 0; j < N; ++j) {
    for (int k = 0; k < j; ++k) for (int i = j; i < N; ++i) A[i][j] -= A[i][k]*A[j][k];
    double d = 1.0/sqrt(A[j][j]);
    for (int i = j; i < N; ++i) A[i][j] *= d;
  }
  for (int i = 0; i < N; ++i) { for (int k = 0; k < i; ++k) b[i] -= A[i][k]*b[k]; b[i] /= A[i][i]; }
  for (int i = N-1; i >= 0; --i) { for (int k = i+1; k < N; ++k) b[i] -= A[k][i]*b[k]; b[i] /= A[i][i]; }
}
"""


def source(device: Device) -> str:
    """Return C: run(calls, q, v, tau, p, out) repeats the forward dynamics, each from the last one's result."""
    tape, n = forward_dynamics(device), len(device.joints)
    needed = {
        symbol for entry in (*tape.bias, *(x for row in tape.mass_matrix for x in row)) for symbol in entry.free_symbols
    }
    lines = []
    for symbol, expression in reversed(tape.definitions):
        if symbol in needed:
            needed |= expression.free_symbols
            lines.append(f"double {symbol} = {sp.ccode(expression)};")
    names = [f"double q{j} = q[{j}], v{j} = v[{j}];" for j in range(n)]
    names += [f"double {quantity.id} = p[{i}];" for i, quantity in enumerate(tape.parameters)]
    M = [f"A[{i}][{j}] = {sp.ccode(tape.mass_matrix[i][j])};" for i in range(n) for j in range(i + 1)]
    b = [f"b[{i}] = tau[{i}] - ({sp.ccode(tape.bias[i])});" for i in range(n)]
    body = "\n".join([*names, *reversed(lines), "double A[N][N], b[N];", *M, *b, "solve(A, b);"])
    return f"""#include <math.h>
#define N {n}
{SOLVE}
void run(long calls, double *q, double *v, double *tau, double *p, double *out) {{
for (long c = 0; c < calls; ++c) {{
{body}
for (int i = 0; i < N; ++i) {{ out[i] = b[i]; q[i] += 1e-12*b[i]; }}
}} }}
"""


def compiled(device: Device, folder: Path) -> ctypes.CDLL:
    """Compile with ziglang."""
    (folder / "fd.c").write_text(source(device))
    library = folder / "fd.so"
    command = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-O3",
        "-mcpu=native",
        "-ffast-math",
        "-shared",
        "-o",
        str(library),
        str(folder / "fd.c"),
    ]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))


def timed(device: Device, calls: int = 300_000) -> tuple[float, np.ndarray]:
    """Return ns per call, and the accelerations at the test state."""
    n = len(device.joints)
    q, v, tau = (np.linspace(a, b, n) for a, b in ((0.2, -0.5), (1.0, -2.0), (0.1, -0.1)))
    out = np.zeros(n)
    with tempfile.TemporaryDirectory() as folder:
        library = compiled(device, Path(folder))
        arrays = [q, v, tau, standard_initial(device), out]
        pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in arrays]
        library.run(ctypes.c_long(1), *pointers)
        first = out.copy()
        best = min(_seconds(library, calls // 5, pointers) for _ in range(5))
    return best / (calls // 5) * 1e9, first


def with_friction(device: Device, rows: int = 4000) -> float:
    """Return ns per right-hand side of the whole device in its own kernel."""
    kernel = CompiledKernel.of(full_equations(device), tangent=False)
    e = kernel.equations
    t = kernel.kernel.step * np.arange(rows)
    u = np.zeros((rows, len(e.inputs)))
    u[:, : len(device.joints)] = 1e-2 * np.cos(2 * t)[:, None]
    p, x0 = np.array([q.initial for q in e.parameters]), np.zeros(len(e.states))
    if not np.isfinite(kernel.simulate(t, u, p, x0)).all():
        raise SystemExit("the whole device left the finite numbers")
    best = np.inf
    for _ in range(7):
        start = time.perf_counter()
        kernel.simulate(t, u, p, x0)
        best = min(best, time.perf_counter() - start)
    return best / (rows - 1) / 4 * 1e9


def _seconds(library: ctypes.CDLL, calls: int, pointers: list[ctypes.c_void_p]) -> float:
    start = time.perf_counter()
    library.run(ctypes.c_long(calls), *pointers)
    return time.perf_counter() - start


def pinocchio_time(device: Device, calls: int = 50_000) -> tuple[float, float, np.ndarray]:
    """Return ns per ABA, ns of the binding's overhead, and the accelerations, for the serial device."""
    import pinocchio as pin  # noqa: PLC0415 (a development dependency)

    model, frames, order = pin.Model(), {"base": 0}, []
    model.gravity = pin.Motion(np.array(device.gravity), np.zeros(3))
    kinds = {(1, 0, 0): pin.JointModelRX, (0, 1, 0): pin.JointModelRY, (0, 0, 1): pin.JointModelRZ}
    for link in device.massive:
        (joint,) = link.moved_by
        placement = pin.SE3(pin.rpy.rpyToMatrix(*link.rpy), np.array(link.origin))
        kind = kinds.get(tuple(int(x) if x == int(x) else x for x in link.axis))  # type: ignore[arg-type]
        made = kind() if kind else pin.JointModelRevoluteUnaligned(np.array(link.axis))
        frames[link.name] = model.addJoint(frames[link.parent], made, placement, link.name)
        m, x, y, z, xx, yy, zz, xy, xz, yz = link.inertial.initial  # type: ignore[union-attr]
        inertia = pin.Inertia(m, np.array([x, y, z]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        model.appendBodyToJoint(frames[link.name], inertia, pin.SE3.Identity())
        order.append(joint)
    n = len(device.joints)
    q, v, tau = (np.linspace(a, b, n)[order] for a, b in ((0.2, -0.5), (1.0, -2.0), (0.1, -0.1)))
    data, empty = model.createData(), pin.Model()
    nothing, none = empty.createData(), np.zeros(0)
    full = min(_loop(lambda: pin.aba(model, data, q, v, tau), calls // 5) for _ in range(5))
    overhead = min(_loop(lambda: pin.aba(empty, nothing, none, none, none), calls // 5) for _ in range(5))
    result = np.empty(n)
    result[order] = pin.aba(model, data, q, v, tau)
    return full, overhead, result


def _loop(function: object, calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        function()  # type: ignore[operator]
    return (time.perf_counter() - start) / calls * 1e9


def main() -> None:
    """Print the figures."""
    device = load_device("freedom6s")
    start = time.perf_counter()
    lagrangian = full_lagrangian(device)
    terms = sum(len(p) for form in lagrangian.christoffel().values() for p in form.values())
    print(
        f"exact M, C, φ of {device.name}: {time.perf_counter() - start:.2f} s, {terms} terms in the Christoffel symbols"
    )
    links = tuple(dataclasses.replace(link, inertial=None) if link.name == "3" else link for link in device.links)
    serial = dataclasses.replace(device, links=links)
    for one in (device, serial, load_device("arm6")):
        start = time.perf_counter()
        operations = sum(e.count_ops() for _, e in forward_dynamics(one).definitions)
        seconds = time.perf_counter() - start
        ours, accelerations = timed(one)
        label = one.name if one is not serial else "freedom6s without rod"
        print(f"{label:22s} tape {seconds:.2f} s, {operations} operations, {ours:.0f} ns per call")
        if one is not device:
            full, overhead, theirs = pinocchio_time(one)
            friction = with_friction(one)
            print(f"{'':22s} with friction, in the FMU's kernel: {friction:.0f} ns per right-hand side")
            print(f"{'':22s} over ABA without its binding: {friction / (full - overhead):.2f} (aim 1.5)")
            agree = np.abs(accelerations - theirs).max() / np.abs(theirs).max()
            print(f"{'':22s} Pinocchio ABA {full:.0f} ns, of which binding {overhead:.0f} ns; difference {agree:.1e}")


if __name__ == "__main__":
    main()
