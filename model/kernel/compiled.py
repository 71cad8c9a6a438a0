"""A compiled kernel, called through ctypes: simulations, sensitivities, many parameter sets at once.

`Equations` come in; NumPy arrays of times, inputs, parameters and initial states become arrays of outputs and their
sensitivities. Sizes: n_t rows, n_x states, n_u inputs, n_p parameters, n_y outputs, n_c sensitivity columns.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haptid.model.equations.equations import Equations
from haptid.model.kernel.compiler import compile_kernel
from haptid.model.kernel.generate import Kernel, generate
from haptid.model.kernel.pieces import pieces
from haptid.model.thresholds import THRESHOLDS

Array = NDArray[np.float64]
LANES = 4
"""Number of parameter sets side by side in one SIMD vector of `CompiledKernel.simulate_many`."""
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


def _check_shape(name: str, values: Any, shape: tuple[int, ...]) -> Array:
    array = _array(values)
    if array.shape != shape:
        msg = f"{name} needs shape {shape}, got {array.shape}"
        raise ValueError(msg)
    return array


def _in_threads(run: Callable[[int], None], tasks: Iterable[int], threads: int) -> None:
    """Run the tasks in threads; at an error or Ctrl-C, cancel the tasks that have not begun."""
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
    """A kernel ready to run; all methods are pure, the same arguments give the same bits.

    Parameters
    ----------
    kernel
        Generated source, or the record of it, with equations and columns.
    path
        Shared library.
    """

    kernel: Kernel
    path: Path

    @classmethod
    def of(
        cls, equations: Equations, *, many: bool = True, substeps: int | None = None, **options: Any
    ) -> CompiledKernel:
        """Generate and compile the kernel of equations; the library is cached by its source.

        Parameters
        ----------
        equations
            Equations of the kernel.
        many
            Whether the kernel has `simulate_many`.
        substeps
            Largest number of sub-steps of an inner step; the kernel's default where None.
        **options
            Further arguments of `generate`.

        Returns
        -------
        CompiledKernel
            The kernel.

        Raises
        ------
        NumericalError
            Where the compiler is missing or fails.
        """
        kernel = generate(equations, **options)
        return cls(kernel, compile_kernel(kernel.source, lanes=LANES if many else 0, substeps=substeps))

    @property
    def equations(self) -> Equations:
        """The equations from which the kernel was generated."""
        return self.kernel.equations

    def with_step(self, step: float) -> CompiledKernel:
        """Return the same kernel with another inner step.

        Parameters
        ----------
        step
            Longest inner step [s], where a call states none.

        Returns
        -------
        CompiledKernel
        """
        return replace(self, kernel=replace(self.kernel, step=step))

    @property
    def _sizes(self) -> tuple[int, int, int, int]:
        e = self.equations
        return len(e.states), len(e.inputs), len(e.parameters), len(e.outputs)

    def _check_arguments(self, t: Any, u: Any, p: Any, x0: Any) -> tuple[Array, Array, Array, Array]:
        nx, nu, np_, _ = self._sizes
        times = _array(t)
        return (
            times,
            _check_shape("u", u, (times.size, nu)),
            _check_shape("p", p, (np_,)),
            _check_shape("x0", x0, (nx,)),
        )

    def linear_bits(self, linear: bool | tuple[bool, ...]) -> int:
        """Encode which inputs run linearly between rows.

        Parameters
        ----------
        linear
            One flag for all inputs, or one flag per input; False for a zero-order hold.

        Returns
        -------
        int
            Number in which bit j is set where input j is linear.
        """
        flags = (linear,) * self._sizes[1] if isinstance(linear, bool) else linear
        return sum(1 << j for j, flag in enumerate(flags) if flag)

    def simulate(
        self, t: Any, u: Any, p: Any, x0: Any, *, linear: bool | tuple[bool, ...] = False, step: float | None = None
    ) -> Array:
        """Simulate the outputs at given times.

        Parameters
        ----------
        t
            Times of the rows [s], shape (n_t,).
        u
            Inputs at the rows, shape (n_t, n_u).
        p
            Parameters, shape (n_p,).
        x0
            State at the first row, shape (n_x,).
        linear
            Whether inputs run linearly between rows, as in `linear_bits`.
        step
            Longest inner step [s]; the kernel's own where None.

        Returns
        -------
        Array
            Outputs, shape (n_t, n_y); rows after the state has become infinite or NaN are NaN.

        Raises
        ------
        ValueError
            Where an array has the wrong shape.
        """
        return self.simulate_through(t, u, p, x0, linear=linear, step=step)[0]

    def simulate_through(
        self, t: Any, u: Any, p: Any, x0: Any, *, linear: bool | tuple[bool, ...] = False, step: float | None = None
    ) -> tuple[Array, Array]:
        """Simulate as `simulate` does, and return the final state too.

        Parameters
        ----------
        t
            Times of the rows [s], shape (n_t,).
        u
            Inputs at the rows, shape (n_t, n_u).
        p
            Parameters, shape (n_p,).
        x0
            State at the first row, shape (n_x,).
        linear
            Whether inputs run linearly between rows, as in `linear_bits`.
        step
            Longest inner step [s]; the kernel's own where None.

        Returns
        -------
        y : Array
            Outputs, shape (n_t, n_y); NaN as for `simulate`.
        state : Array
            State at the last row, shape (n_x,); a simulation that continues from it has the same bits as one without
            interruption.

        Raises
        ------
        ValueError
            Where an array has the wrong shape.
        """
        times, inputs, parameters, start = self._check_arguments(t, u, p, x0)
        y, state, h = np.full((times.size, self._sizes[3]), np.nan), start.copy(), step or self.kernel.step
        for rows in pieces(times, h):
            size = rows.stop - rows.start
            # the state is read and written in place: each piece starts from the final state of the one before
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
        """Simulate the outputs with their first-order sensitivities.

        Parameters
        ----------
        t
            Times of the rows [s], shape (n_t,).
        u
            Inputs at the rows, shape (n_t, n_u).
        p
            Parameters, shape (n_p,).
        x0
            State at the first row, shape (n_x,).
        linear
            Whether inputs run linearly between rows, as in `linear_bits`.
        step
            Longest inner step [s]; the kernel's own where None.

        Returns
        -------
        y : Array
            Outputs, shape (n_t, n_y).
        dy : Array
            Derivatives of the outputs with respect to ``kernel.columns`` (parameters, then initial states), shape
            (n_t, n_y, n_c).

        Raises
        ------
        ValueError
            Where the kernel has no sensitivities, or an array has the wrong shape.
        """
        times, inputs, parameters, start = self._check_arguments(t, u, p, x0)
        columns = len(self.kernel.columns)
        if not columns:
            msg = f"{self.equations.name} was generated without sensitivities"
            raise ValueError(msg)
        y = np.full((times.size, self._sizes[3]), np.nan)
        dy = np.full((times.size, self._sizes[3], columns), np.nan)
        state, h = start.copy(), step or self.kernel.step
        # ∂x₀/∂p = 0 and ∂x₀/∂x₀ = 1
        starts = self.kernel.starts
        slopes = np.hstack((np.zeros((state.size, columns - len(starts))), np.eye(state.size)[:, starts]))
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
        """Simulate many parameter sets side by side, in SIMD lanes and in threads.

        Parameters
        ----------
        t
            Times of the rows [s], shape (n_t,).
        u
            Inputs at the rows, common to all sets, shape (n_t, n_u).
        p
            Parameters of each set, shape (n_sets, n_p).
        x0
            State of each set at the first row, shape (n_sets, n_x).
        linear, step
            As for `simulate`.
        threads
            Number of threads.

        Returns
        -------
        Array
            Outputs, shape (n_sets, n_t, n_y), with the same bits as `simulate` gives for each set; a set whose state
            became infinite or NaN is NaN throughout.

        Raises
        ------
        ValueError
            Where an array has the wrong shape.
        """
        nx, nu, np_, ny = self._sizes
        times, parameters = _array(t), _array(p)
        sets = parameters.shape[0]
        inputs = _check_shape("u", u, (times.size, nu))
        parameters, start = _check_shape("p", parameters, (sets, np_)), _check_shape("x0", x0, (sets, nx))
        y = np.full((sets, times.size, ny), np.nan)
        done = np.zeros(sets, dtype=np.int8)
        bits, h, library = self.linear_bits(linear), step or self.kernel.step, _load(self.path)
        # a call has at most about so many inner steps of LANES sets, so that Ctrl-C is noticed between calls
        by_call = int(LANES * THRESHOLDS.most_inner_steps_of_call / (times.size + np.ptp(times) / h)) // LANES * LANES
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
        """Integrate the state over one time step.

        Parameters
        ----------
        x
            State at t, shape (n_x,).
        t, dt
            Start and length of the step [s].
        u
            Inputs at t, shape (n_u,).
        p
            Parameters, shape (n_p,).
        slope
            Rates of change of the inputs, per second, shape (n_u,); 0 where None.
        step
            Longest inner step [s]; the kernel's own where None.

        Returns
        -------
        Array
            State at t + dt, shape (n_x,); NaN throughout where the state became infinite or NaN.

        Raises
        ------
        ValueError
            Where an array has the wrong shape.
        """
        nx, nu, np_, _ = self._sizes
        state, u, p = _check_shape("x", x, (nx,)).copy(), _check_shape("u", u, (nu,)), _check_shape("p", p, (np_,))
        slopes = np.zeros(nu) if slope is None else _check_shape("slope", slope, (nu,))
        finite = _load(self.path).hk_advance(
            state.ctypes.data, t, dt, u.ctypes.data, slopes.ctypes.data, p.ctypes.data, step or self.kernel.step
        )
        return state if finite else np.full(nx, np.nan)

    def derivatives(self, t: float, x: Any, u: Any, p: Any) -> Array:
        """Return the rates of change ẋ = f(t, x, u, p).

        Parameters
        ----------
        t
            Time [s].
        x
            State, shape (n_x,).
        u
            Inputs, shape (n_u,).
        p
            Parameters, shape (n_p,).

        Returns
        -------
        Array
            Rates of change, in the units of the states per second, shape (n_x,).

        Raises
        ------
        ValueError
            Where an array has the wrong shape.
        """
        nx, nu, np_, _ = self._sizes
        x, u, p = _check_shape("x", x, (nx,)), _check_shape("u", u, (nu,)), _check_shape("p", p, (np_,))
        f = np.empty(nx)
        _load(self.path).hk_derivatives(t, x.ctypes.data, u.ctypes.data, p.ctypes.data, f.ctypes.data)
        return f

    def output(self, t: float, x: Any, u: Any, p: Any) -> Array:
        """Return the outputs y = g(t, x, u, p).

        Parameters
        ----------
        t
            Time [s].
        x
            State, shape (n_x,).
        u
            Inputs, shape (n_u,).
        p
            Parameters, shape (n_p,).

        Returns
        -------
        Array
            Outputs in their units, shape (n_y,).

        Raises
        ------
        ValueError
            Where an array has the wrong shape.
        """
        nx, nu, np_, ny = self._sizes
        x, u, p = _check_shape("x", x, (nx,)), _check_shape("u", u, (nu,)), _check_shape("p", p, (np_,))
        y = np.empty(ny)
        _load(self.path).hk_output(t, x.ctypes.data, u.ctypes.data, p.ctypes.data, y.ctypes.data)
        return y
