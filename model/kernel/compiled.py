"""A compiled kernel, called through ctypes: simulations, sensitivities, many parameter sets at once."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haptid.model.equations.equations import Equations
from haptid.model.kernel.compiler import compile_kernel
from haptid.model.kernel.generate import Kernel, generate
from haptid.model.kernel.pieces import MOST_STEPS, pieces

Array = NDArray[np.float64]
LANES = 4
"""Parameter sets side by side in `CompiledKernel.simulate_many`."""
_double, _long, _int = ctypes.c_double, ctypes.c_long, ctypes.c_int
_p = ctypes.c_void_p


@lru_cache(maxsize=256)
def _load(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    signatures = {
        "hk_simulate": (_long, (_long, _p, _p, _int, _p, _p, _double, _p, _p)),
        "hk_simulate_tangent": (_long, (_long, _p, _p, _int, _p, _p, _p, _double, _p, _p, _p, _p)),
        "hk_simulate_lanes": (_long, (_long, _long, _long, _p, _p, _int, _p, _p, _double, _p, _p)),
        "hk_advance": (_int, (_p, _double, _double, _p, _p, _p, _double)),
        "hk_derivatives": (None, (_double, _p, _p, _p, _p)),
        "hk_output": (None, (_double, _p, _p, _p, _p)),
    }
    for name, (result, arguments) in signatures.items():
        if hasattr(library, name):
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    return library


def _array(values: Any) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def _shaped(name: str, values: Any, shape: tuple[int, ...]) -> Array:
    array = _array(values)
    if array.shape != shape:
        msg = f"{name} needs shape {shape}, got {array.shape}"
        raise ValueError(msg)
    return array


def _in_threads(run: Callable[[int], None], tasks: Iterable[int], threads: int) -> None:
    """Run the tasks; where Ctrl-C comes, those that have not begun are dropped."""
    with ThreadPoolExecutor(threads) as pool:
        futures = [pool.submit(run, task) for task in tasks]
        try:
            for future in futures:
                future.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


@dataclass(frozen=True, slots=True)
class CompiledKernel:
    """A kernel ready to run. All methods are pure: same arguments, same bits."""

    kernel: Kernel
    path: Path

    @classmethod
    def of(
        cls, equations: Equations, *, many: bool = True, substeps: int | None = None, **options: Any
    ) -> CompiledKernel:
        """Generate and compile ``equations``, with `simulate_many` where ``many``; cached by its source.

        A step is cut into at most ``substeps``, the kernel's own number where None.
        """
        kernel = generate(equations, **options)
        return cls(kernel, compile_kernel(kernel.source, lanes=LANES if many else 0, substeps=substeps))

    @property
    def equations(self) -> Equations:
        """The equations this was generated from."""
        return self.kernel.equations

    @property
    def _sizes(self) -> tuple[int, int, int, int]:
        e = self.equations
        return len(e.states), len(e.inputs), len(e.parameters), len(e.outputs)

    def _prepared(self, t: Any, u: Any, p: Any, x0: Any) -> tuple[Array, Array, Array, Array]:
        nx, nu, np_, _ = self._sizes
        times = _array(t)
        return times, _shaped("u", u, (times.size, nu)), _shaped("p", p, (np_,)), _shaped("x0", x0, (nx,))

    def linear_bits(self, linear: bool | tuple[bool, ...]) -> int:
        """Bit j is set where input j runs linearly between rows."""
        flags = (linear,) * self._sizes[1] if isinstance(linear, bool) else linear
        return sum(1 << j for j, flag in enumerate(flags) if flag)

    def simulate(
        self, t: Any, u: Any, p: Any, x0: Any, *, linear: bool | tuple[bool, ...] = False, step: float | None = None
    ) -> Array:
        """Return outputs y (n_t, n_y) at times t (n_t,) for inputs u (n_t, n_u), parameters p (n_p,), start x0 (n_x,).

        Rows after the state has left the finite numbers are NaN.
        """
        return self.simulate_through(t, u, p, x0, linear=linear, step=step)[0]

    def simulate_through(
        self, t: Any, u: Any, p: Any, x0: Any, *, linear: bool | tuple[bool, ...] = False, step: float | None = None
    ) -> tuple[Array, Array]:
        """As `simulate`, with the state (n_x,) at the last row: going on from there has the same bits."""
        times, inputs, parameters, start = self._prepared(t, u, p, x0)
        y, state, h = np.full((times.size, self._sizes[3]), np.nan), start.copy(), step or self.kernel.step
        for rows in pieces(times, h):
            size = rows.stop - rows.start
            done = _load(self.path).hk_simulate(
                size,
                times[rows].ctypes.data,
                inputs[rows].ctypes.data,
                self.linear_bits(linear),
                parameters.ctypes.data,
                state.ctypes.data,
                h,
                y[rows].ctypes.data,
                state.ctypes.data,
            )
            if done < size:
                break
        return y, state

    def simulate_tangent(
        self, t: Any, u: Any, p: Any, x0: Any, *, linear: bool | tuple[bool, ...] = False, step: float | None = None
    ) -> tuple[Array, Array]:
        """As `simulate`, with dy (n_t, n_y, n_c), the derivatives along ``kernel.columns``."""
        times, inputs, parameters, start = self._prepared(t, u, p, x0)
        columns = len(self.kernel.columns)
        if not columns:
            msg = f"{self.equations.name} was generated without sensitivities"
            raise ValueError(msg)
        y = np.full((times.size, self._sizes[3]), np.nan)
        dy = np.full((times.size, self._sizes[3], columns), np.nan)
        state, h = start.copy(), step or self.kernel.step
        slopes = np.hstack((np.zeros((state.size, columns - state.size)), np.eye(state.size)))
        for rows in pieces(times, h):
            size = rows.stop - rows.start
            done = _load(self.path).hk_simulate_tangent(
                size,
                times[rows].ctypes.data,
                inputs[rows].ctypes.data,
                self.linear_bits(linear),
                parameters.ctypes.data,
                state.ctypes.data,
                slopes.ctypes.data,
                h,
                y[rows].ctypes.data,
                dy[rows].ctypes.data,
                state.ctypes.data,
                slopes.ctypes.data,
            )
            if done < size:
                break
        return y, dy

    def simulate_many(
        self,
        t: Any,
        u: Any,
        p: Any,
        x0: Any,
        *,
        linear: bool | tuple[bool, ...] = False,
        step: float | None = None,
        threads: int = 1,
    ) -> Array:
        """Return outputs (n_sets, n_t, n_y) for parameter sets p (n_sets, n_p) and initial states x0 (n_sets, n_x).

        A set that blew up is NaN throughout. Sets run side by side in SIMD lanes and in ``threads``; every set has
        the same bits as `simulate` gives it.
        """
        nx, nu, np_, ny = self._sizes
        times, parameters = _array(t), _array(p)
        sets = parameters.shape[0]
        inputs = _shaped("u", u, (times.size, nu))
        parameters, start = _shaped("p", parameters, (sets, np_)), _shaped("x0", x0, (sets, nx))
        y = np.full((sets, times.size, ny), np.nan)
        done = np.zeros(sets, dtype=np.int8)
        bits, h, library = self.linear_bits(linear), step or self.kernel.step, _load(self.path)
        by_call = int(LANES * MOST_STEPS / (times.size + np.ptp(times) / h)) // LANES * LANES
        chunk = max(LANES, min(by_call, -(-sets // threads)))

        def run(first: int) -> None:
            library.hk_simulate_lanes(
                first,
                min(first + chunk, sets),
                times.size,
                times.ctypes.data,
                inputs.ctypes.data,
                bits,
                parameters.ctypes.data,
                start.ctypes.data,
                h,
                y.ctypes.data,
                done.ctypes.data,
            )

        if threads == 1:
            for first in range(0, sets, chunk):
                run(first)
        else:
            _in_threads(run, range(0, sets, chunk), threads)
        y[done == 0] = np.nan
        return y

    def advance(
        self, x: Any, t: float, dt: float, u: Any, p: Any, *, slope: Any = None, step: float | None = None
    ) -> Array:
        """Return the state (n_x,) a time dt after x at t, for inputs u (n_u,) with ``slope`` (n_u,) per second.

        NaN throughout where the state left the finite numbers.
        """
        nx, nu, np_, _ = self._sizes
        state, u, p = _shaped("x", x, (nx,)).copy(), _shaped("u", u, (nu,)), _shaped("p", p, (np_,))
        slopes = np.zeros(nu) if slope is None else _shaped("slope", slope, (nu,))
        finite = _load(self.path).hk_advance(
            state.ctypes.data, t, dt, u.ctypes.data, slopes.ctypes.data, p.ctypes.data, step or self.kernel.step
        )
        return state if finite else np.full(nx, np.nan)

    def derivatives(self, t: float, x: Any, u: Any, p: Any) -> Array:
        """ẋ (n_x,) at one point."""
        nx, nu, np_, _ = self._sizes
        x, u, p = _shaped("x", x, (nx,)), _shaped("u", u, (nu,)), _shaped("p", p, (np_,))
        f = np.empty(nx)
        _load(self.path).hk_derivatives(t, x.ctypes.data, u.ctypes.data, p.ctypes.data, f.ctypes.data)
        return f

    def output(self, t: float, x: Any, u: Any, p: Any) -> Array:
        """Return outputs (n_y,) at one point."""
        nx, nu, np_, ny = self._sizes
        x, u, p = _shaped("x", x, (nx,)), _shaped("u", u, (nu,)), _shaped("p", p, (np_,))
        y = np.empty(ny)
        _load(self.path).hk_output(t, x.ctypes.data, u.ctypes.data, p.ctypes.data, y.ctypes.data)
        return y
