"""The reference run of an FMU: `Interface` in, `Reference` out, the inputs and outputs that any host must reproduce.

Every torque is a cosine of four times the joint's stiction, so that the joint slides; other inputs are 0. Hosts read
outputs when a step is done, before they set the next inputs. So does the run: outputs that use inputs agree as well.
"""

from __future__ import annotations

import ctypes
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.native.c_source import bare_library, flat_source
from haptid.fmu_build.native.platforms import this_platform
from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.equations.equations import Equations
from haptid.model.friction.registry import law_named
from haptid.support.errors import InputError

Array = NDArray[np.float64]
ROWS, STEP, OMEGA, AMPLITUDE_OVER_STICTION = 401, 0.005, 2.0, 4.0
"""Rows, time between rows [s], angular frequency of the torque [rad/s], and its amplitude over the stiction."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """Hold a reference run.

    Parameters
    ----------
    t
        Time [s], shape (n_t,).
    u
        Inputs held between rows, in their units, shape (n_t, n_u).
    y
        Outputs at the rows, in their units, shape (n_t, n_y): the first after initialisation with the first inputs, the
        others at the end of a step, before the row's own inputs are set.
    name
        Model identifier.
    inputs, outputs
        FMU variable names of the columns.
    """

    t: Array
    u: Array
    y: Array
    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def files(self) -> dict[str, bytes]:
        """Write the files of the FMI cross-check.

        Returns
        -------
        dict
            Content by file name: inputs (``<name>_in.csv``), outputs (``_ref.csv``), options (``_ref.opt``). Numbers
            keep their last bit.
        """
        options = {"StartTime": self.t[0], "StopTime": self.t[-1], "StepSize": STEP, "RelTol": 0.0}
        return {
            f"{self.name}_in.csv": _csv(("time", *self.inputs), np.column_stack((self.t, self.u))),
            f"{self.name}_ref.csv": _csv(("time", *self.outputs), np.column_stack((self.t, self.y))),
            f"{self.name}_ref.opt": "".join(f"{key}, {float(x)!r}\n" for key, x in options.items()).encode(),
        }


class OverflowingError(InputError):
    """A model's reference run gives no finite numbers."""


def _csv(header: Sequence[str], rows: Array) -> bytes:
    stream = io.StringIO()
    stream.write(",".join(f'"{name}"' for name in header) + "\n")
    stream.writelines(",".join(repr(float(value)) for value in row) + "\n" for row in rows)
    return stream.getvalue().encode()


@lru_cache(maxsize=64)
def _library(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    library.hf_step.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double]
    library.hf_output.argtypes = [ctypes.c_void_p, ctypes.c_double]
    return library


def reference(interface: Interface) -> Reference | None:
    """Run the compiled kernel on this machine.

    Parameters
    ----------
    interface
        Variables and kernel of the FMU, at its start values.

    Returns
    -------
    Reference or None
        401 rows over 2 s; None where this machine is none of `PLATFORMS`.

    Raises
    ------
    OverflowingError
        Where an output is not finite.
    NumericalError
        Where the compiler is missing or fails.
    """
    here = this_platform()
    if not here:
        return None
    library = _library(bare_library(flat_source(interface.kernel), here[0].triple))
    t: Array = STEP * np.arange(ROWS, dtype=np.float64)
    u = _inputs(interface, t)
    at, n_y = interface.offsets, len(interface.equations.outputs)
    values, y = np.array(interface.start), np.full((t.size, n_y), np.nan)
    shown, driven = values[at["y"] : at["y"] + n_y], values[at["u"] : at["u"] + u.shape[1]]
    driven[:] = u[0]
    library.hf_output(values.ctypes.data, t[0])
    y[0] = shown
    for k in range(t.size - 1):
        driven[:] = u[k]
        if not library.hf_step(values.ctypes.data, t[k], t[k + 1] - t[k]):
            break
        y[k + 1] = shown
    _check_finite(interface, t, y)
    names = [tuple(v.name for v in interface.of_role(role)) for role in ("input", "output")]
    return Reference(t=t, u=u, y=y, name=interface.identifier, inputs=names[0], outputs=names[1])


def _check_finite(interface: Interface, t: Array, y: Array) -> None:
    """Refuse a model whose reference run overflows: the magnitude of some parameter is implausible."""
    broken = np.argwhere(~np.isfinite(y))
    if broken.size == 0:
        return
    row, column = broken[0]
    output = interface.of_role("output")[column].name
    got = f"{y[row, column]} in {output} at {t[row]:g} s"
    # The error names the value whose magnitude is farthest from 1, the likeliest slip of a unit or an exponent.
    furthest = max(interface.of_role("parameter"), key=lambda v: abs(np.log10(abs(v.start or 1.0))))
    todo = f"look at its values, as at {furthest.name} = {furthest.start:g}"
    raise OverflowingError(interface.title, expected="finite outputs of the reference run", got=got, todo=todo)


def _inputs(interface: Interface, t: Array) -> Array:
    start = {v.id: v.start for v in interface.of_role("parameter")}
    # An input at its start value keeps a drive in the run: with the motor let go it would test nothing of it.
    u = np.tile([v.start or 0.0 for v in interface.of_role("input")], (t.size, 1))
    for i, v in enumerate(interface.of_role("input")):
        if v.id.startswith("tau"):
            stiction = start.get(_stiction(interface.equations, v.id))
            otherwise = THRESHOLDS.reference_amplitude_without_stiction_Nm
            amplitude = AMPLITUDE_OVER_STICTION * stiction if stiction else otherwise
            u[:, i] = amplitude * np.cos(OMEGA * t)
    return u


def _stiction(e: Equations, id: str) -> str:
    """Return the id of the stiction of the joint that an input ``tau`` or ``tau3`` drives; '' where it has none."""
    number = id.removeprefix("tau")
    numbers = map(str, e.joints) if number else ("",)
    laws = dict(zip(numbers, e.friction, strict=False))
    if number not in laws:
        return ""
    stiction = law_named(laws[number]).roles.stiction
    return f"{stiction}_{number}" if number else stiction
