"""The FMU as a `Simulator`: `Fmu` and `Equations` in, `FmuSimulator` out; fits and samplers run it by default.

1. The archive is unpacked and loaded once per process (`FmuSlave`).
2. For every simulation, parameters, initial states, inner step and constant inputs are set as start values.
3. Inputs that change are set at every row, with their slopes, and the outputs are read.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from haptid.fmu_build.building.packaging import Fmu
from haptid.fmu_build.description.variables import sensitivity_name, structured_name
from haptid.identification.simulators.fmu_slave import FmuSlave
from haptid.identification.simulators.protocol import (
    Trajectory,
    as_recorded,
    initial_state,
    observer_hold,
    observer_inputs,
)
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.fmu_names import INNER_STEP, SENSITIVITY_SWITCH
from haptid.model.equations.output_injection import with_observer
from haptid.model.kernel.tangent import tangent_columns
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import NumericalError


@lru_cache(maxsize=64)
def _open(path: Path, digest: str) -> FmuSlave:  # noqa: ARG001 # the digest keeps a rebuilt file apart from its predecessor
    return FmuSlave(path)


@dataclass(frozen=True, slots=True, kw_only=True)
class References:
    """Value references of an identification FMU.

    Parameters
    ----------
    inputs
        Torques, measured positions and observer gain, in the order of `observer_inputs`.
    slopes
        Slopes of the inputs in time, for every input but the gain.
    states, parameters, outputs
        Initial states, parameters and outputs in the order of the equations.
    sensitivities
        Derivatives of the outputs by parameters and initial states, output by output.
    switch, step
        Boolean that switches the sensitivities on; longest inner step.
    """

    inputs: tuple[int, ...]
    slopes: tuple[int, ...]
    states: tuple[int, ...]
    parameters: tuple[int, ...]
    outputs: tuple[int, ...]
    sensitivities: tuple[int, ...]
    switch: int
    step: int


def _references(slave: FmuSlave, equations: Equations) -> References:
    e = with_observer(equations)

    def of(*names: str) -> tuple[int, ...]:
        return tuple(slave.references[name] for name in names)

    inputs = [structured_name(e, x.id, x.structured) for x in e.inputs]
    return References(
        inputs=of(*inputs),
        slopes=of(*(f"{name}_slope" for name in inputs[:-1])),
        states=of(*(structured_name(e, x.id, x.structured) for x in e.states)),
        parameters=of(*(structured_name(e, x.id, x.structured) for x in e.parameters)),
        outputs=of(*(structured_name(e, x.id, x.structured) for x in e.outputs)),
        sensitivities=of(*(sensitivity_name(y.id, c) for y in e.outputs for c in tangent_columns(e))),
        switch=slave.references[SENSITIVITY_SWITCH],
        step=slave.references[INNER_STEP],
    )


@dataclass(frozen=True, slots=True)
class FmuSimulator:
    """Simulator that runs an identification FMU through fmpy and the compiled loop; satisfies `Simulator`.

    It is picklable: another process loads the FMU again from its path.

    Parameters
    ----------
    path, digest
        The FMU, built with ``identification=True``, and the digest of its content.
    equations
        The equations without observer, with the bounds and first guesses of the fit.
    references
        Value references of its variables.
    step
        Longest inner step [s].
    """

    path: Path
    digest: str
    equations: Equations
    references: References
    step: float = THRESHOLDS.inner_step_s

    @classmethod
    def of(cls, fmu: Fmu | Path, equations: Equations) -> FmuSimulator:
        """Open an identification FMU.

        Parameters
        ----------
        fmu
            FMU, or the path of its archive.
        equations
            Equations that the FMU was built from; bounds, priors and first guesses may differ.

        Returns
        -------
        FmuSimulator

        Raises
        ------
        ValueError
            Where the FMU was built without ``identification=True`` and has no sensitivities.
        NumericalError
            Where the FMU cannot be loaded.
        """
        path = fmu if isinstance(fmu, Path) else fmu.path
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
        slave = _open(path, digest)
        if SENSITIVITY_SWITCH not in slave.references:
            msg = f"{path}: fits need an FMU that was built with identification=True"
            raise ValueError(msg)
        return cls(path, digest, equations, _references(slave, equations))

    def with_step(self, step: float) -> FmuSimulator:
        """Return the same FMU with another inner step.

        Parameters
        ----------
        step
            Longest inner step [s].

        Returns
        -------
        FmuSimulator
        """
        return replace(self, step=step)

    def _check(self, theta: Array) -> None:
        for q, value in zip(self.equations.parameters, theta, strict=True):
            if not np.isfinite(value):
                msg = f"{self.path.name}: parameter {q.id}: expected a finite value, got {value}"
                raise NumericalError(msg)

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`.

        Raises
        ------
        NumericalError
            Where a parameter is not finite, or the FMU refuses its start values or first inputs.
        """
        e, at = self.equations, self.references
        self._check(theta)
        state = initial_state(e, run) if x0 is None else np.asarray(x0, dtype=float)
        inputs, table = _drive(at, run, gain)
        # Inputs that never change are start values: the loop then sets fewer variables at every row.
        varying = np.any(table != table[0], axis=0)
        start = dict(zip(at.parameters, np.asarray(theta, dtype=float), strict=True))
        start |= dict(zip(at.states, state, strict=True))
        start[at.step] = self.step
        start |= {r: value for r, value, moves in zip(inputs, table[0], varying, strict=True) if not moves}
        moving = [r for r, moves in zip(inputs, varying, strict=True) if moves]
        outputs = at.outputs + at.sensitivities if sensitivities else at.outputs
        slave = _open(self.path, self.digest)
        with slave.lock:
            slave.initialise(start, switches={at.switch: sensitivities}, time=float(run.t[0]))
            result = slave.run(run.t, moving, table[:, varying], outputs, step=self.step)
        if not sensitivities:
            return as_recorded(run, Trajectory(t=run.t, y=result))
        n_y, n_p = len(e.outputs), len(e.parameters)
        dy = result[:, n_y:].reshape(run.t.size, n_y, -1)
        made = Trajectory(t=run.t, y=result[:, :n_y].copy(), dy_dtheta=dy[..., :n_p], dy_dx0=dy[..., n_p:])
        return as_recorded(run, made)


def _drive(at: References, run: Run, gain: float) -> tuple[tuple[int, ...], Array]:
    """Return the value references of all inputs and slopes, and their values, shape (n_t, n_inputs + n_slopes)."""
    u = observer_inputs(run, gain)
    if gain == 0.0:
        first = run.inputs.shape[1]
        # Without gain the measured position does nothing: it need not be set at every row.
        u[:, first : first + len(run.free_joints)] = run.y[0]
    linear = np.array(observer_hold(run))[: len(at.slopes)]
    slopes = np.zeros((run.t.size, len(at.slopes)))
    slopes[:-1] = np.where(linear, np.diff(u[:, : len(at.slopes)], axis=0) / np.diff(run.t)[:, None], 0.0)
    return at.inputs + at.slopes, np.column_stack((u, slopes))
