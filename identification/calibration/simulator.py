"""A foreign FMU behind the `Simulator` protocol: parameters and `Run` in, outputs with difference quotients out.

An FMU gives no sensitivities of its outputs by its parameters (its directional derivatives hold at one instant), so
that every parameter costs two more simulations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from haptid.identification.foreign.process import ForeignFmu, ReportedError
from haptid.identification.problem.parametrisation import linear_unit
from haptid.identification.simulators.protocol import Trajectory
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity


def equations_of(name: str, quantities: tuple[Quantity, ...]) -> Equations:
    """Return equations that hold parameters and no formula: an FMU shows none.

    Parameters
    ----------
    name
        Name and title of the equations.
    quantities
        Parameters of the FMU.

    Returns
    -------
    Equations
        Without joints, states, inputs and outputs.
    """
    return Equations(
        name=name,
        title=name,
        joints=(),
        states=(),
        inputs=(),
        outputs=(),
        parameters=quantities,
        rhs=(),
        rates=(),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ForeignSimulator:
    """Simulator that runs an FMU; satisfies `Simulator`.

    Parameters
    ----------
    fmu
        The FMU.
    equations
        Its parameters, as `equations_of` holds them.
    outputs
        Variables in the order of the columns of a run's ``y``.
    starts
        Further start values by file of a run and variable.
    steps
        Step of each parameter's difference quotient over the size of the parameter [1], shape (n_p,); the narrowest one
        where empty.
    """

    fmu: ForeignFmu
    equations: Equations
    outputs: tuple[str, ...]
    starts: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    steps: tuple[float, ...] = ()

    def outputs_at(self, theta: Array, run: Run) -> Array:
        """Simulate a run.

        Parameters
        ----------
        theta
            Parameters, shape (n_p,).
        run
            Times and inputs.

        Returns
        -------
        ndarray, shape (n_t, n_outputs)
            Outputs in the units of their variables.

        Raises
        ------
        NumericalError
            Where the FMU fails, see `ForeignFmu.simulate`.
        """
        values = {q.structured: float(p) for q, p in zip(self.equations.parameters, theta, strict=True)}
        start = {**self.starts.get(run.file, {}), **values}
        linear = run.hold == "linear"
        return self.fmu.simulate(run.t, start=start, inputs=run.drive_inputs, outputs=self.outputs, linear=linear)

    def simulate(
        self,
        theta: Array,
        run: Run,
        *,
        x0: Array | None = None,  # noqa: ARG002 # an FMU's initial state is among its start values
        gain: float = 0.0,
        sensitivities: bool = False,
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`; NaN where the FMU refuses the parameters.

        Raises
        ------
        NumericalError
            Where the FMU ends its process, or gives no answer in time.
        ValueError
            For a gain other than 0: an FMU has no observer.
        """
        if gain:
            msg = "a foreign FMU has no observer: use gains=(0.0,)"
            raise ValueError(msg)
        y = self._or_nan(theta, run)
        if not sensitivities:
            return Trajectory(t=run.t, y=y)
        dy = np.zeros((*y.shape, theta.size))
        # Where the middle is not finite, the cost is infinite whatever the slopes.
        if np.isfinite(y).all():
            for i, quantity in enumerate(self.equations.parameters):
                if not quantity.fixed:
                    step = self.steps[i] if self.steps else THRESHOLDS.difference_steps_over_size[0]
                    dy[..., i] = self.quotient(theta, i, step, run, y)
        return Trajectory(t=run.t, y=y, dy_dtheta=dy, dy_dx0=np.zeros((*y.shape, 0)))

    def _or_nan(self, theta: Array, run: Run) -> Array:
        try:
            return self.outputs_at(theta, run)
        except ReportedError:
            return np.full((run.t.size, len(self.outputs)), np.nan)

    def quotient(self, theta: Array, i: int, step: float, run: Run, middle: Array) -> Array:
        """Differentiate the outputs by one parameter, by a central difference within the bounds.

        Parameters
        ----------
        theta
            Parameters, shape (n_p,).
        i
            Place of the parameter.
        step
            Step over the size of the parameter [1].
        run
            Times and inputs.
        middle
            Outputs at ``theta``, shape (n_t, n_outputs).

        Returns
        -------
        ndarray, shape (n_t, n_outputs)
            ∂y/∂θᵢ in the unit of the output over that of the parameter; one-sided at a bound or where the FMU refuses a
            side, NaN where it refuses both.
        """
        quantity = self.equations.parameters[i]
        step *= max(abs(theta[i]), THRESHOLDS.least_size_of_difference_step_over_unit * linear_unit(quantity))
        above, below = theta.copy(), theta.copy()
        above[i] = min(theta[i] + step, quantity.upper)
        below[i] = max(theta[i] - step, quantity.lower)
        y_above, y_below = self._or_nan(above, run), self._or_nan(below, run)
        # At a bound, or where the FMU refuses one side, the difference to the middle is left.
        if not np.isfinite(y_above).all():
            above, y_above = theta, middle
        if not np.isfinite(y_below).all():
            below, y_below = theta, middle
        if above[i] == below[i]:
            return np.full_like(middle, np.nan)
        return np.asarray((y_above - y_below) / (above[i] - below[i]))
