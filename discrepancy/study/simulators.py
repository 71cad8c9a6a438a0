"""Build two-step simulators of a joint with effects: `Equations` in, `TwoStep` out.

Readings are integrated at a fine inner step, sensitivities at a coarse one. A minimum lies where Jᵀr = 0. The
integration error in r moves that minimum and stays in the residual, where it would pass for missing physics. The same
error in J only costs a few more iterations. So only the readings need the fine step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Trajectory
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.output_injection import with_observer
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.thresholds import THRESHOLDS as KERNELS

_compiled: dict[tuple[str, tuple[int, ...], bool, bool], CompiledKernel] = {}


def compile_kernel(equations: Equations, *, many: bool = False, tangent: bool = True) -> CompiledKernel:
    """Compile the kernel of ``equations`` with output injection, once per process.

    It has sensitivities by the initial values that are fitted, which of a friction law with twelve states are two.

    Parameters
    ----------
    equations
        Equations without observer; the observer is added here.
    many
        Whether the kernel also simulates many parameter sets at once. This takes longer to compile.
    tangent
        Whether the kernel also integrates sensitivities. This takes longer to compile.

    Returns
    -------
    CompiledKernel
        Kernel from the cache of this process, or a freshly compiled one.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    key = (equations.digest, equations.starts, many, tangent)
    if key not in _compiled:
        _compiled[key] = cached_kernel(
            with_observer(equations), many=many, tangent=tangent, starts=equations.starts,
            substeps=KERNELS.most_substeps_of_inner_step,
        )  # fmt: skip
    return _compiled[key]


@dataclass(frozen=True, slots=True)
class TwoStep:
    """Simulate readings at a fine inner step, and sensitivities and parameter sets at a coarse one.

    Parameters
    ----------
    fine
        Simulator at the inner step of the readings.
    coarse
        Simulator at the inner step of the sensitivities.
    sketch
        Inner step of many parameter sets [s].
    """

    fine: KernelSimulator
    coarse: KernelSimulator
    sketch: float = THRESHOLDS.study.signature_step_s

    @property
    def equations(self) -> Equations:
        """Equations with bounds and first guesses, without observer."""
        return self.fine.equations

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`: readings of the fine step, slopes of the coarse one."""
        if not sensitivities:
            return self.fine.simulate(theta, run, x0=x0, gain=gain)
        rough = self.coarse.simulate(theta, run, x0=x0, gain=gain, sensitivities=True)
        # Where both steps are equal the second simulation would repeat the first; where the coarse one diverged, its
        # sensitivities are of no use, so the readings report the divergence.
        if self.fine.step >= self.coarse.step or not np.isfinite(rough.y).all():
            return rough
        return replace(rough, y=self.fine.simulate(theta, run, x0=x0, gain=gain).y)

    def simulate_many(self, thetas: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0) -> Array:
        """Simulate one run for many parameter sets at the inner step `sketch`.

        Parameters
        ----------
        thetas
            Parameter sets, shape (n_sets, n_p).
        run
            Run whose torque drives the joint.
        x0
            Initial state, shape (n_x,).
        gain
            Observer gain [1/s].

        Returns
        -------
        ndarray
            Readings [rad], shape (n_sets, n_t, n_y).
        """
        return self.coarse.with_step(self.sketch).simulate_many(thetas, run, x0=x0, gain=gain)


@dataclass(frozen=True, slots=True)
class Factory:
    """Turn equations into a simulator; the search depends on this factory and on no concrete simulator.

    Parameters
    ----------
    step
        Inner step of the readings [s]. Sensitivities are integrated at this step too where it is longer than `coarse`.
    share
        Share of `coarse_step_s` and `signature_step_s` that this joint's motion needs [1].
    """

    step: float = THRESHOLDS.study.coarse_step_s
    share: float = 1.0

    @property
    def coarse(self) -> float:
        """Inner step of sensitivities and of first tries [s]."""
        return self.share * THRESHOLDS.study.coarse_step_s

    @property
    def sketch(self) -> float:
        """Inner step of signatures and of the first sieve [s]."""
        return self.share * THRESHOLDS.study.signature_step_s

    def __call__(self, equations: Equations, *, many: bool = False, tangent: bool = True) -> TwoStep:
        """Build the simulator of ``equations``.

        Parameters
        ----------
        equations
            Equations without observer.
        many
            Whether the simulator runs many parameter sets at once.
        tangent
            Whether the simulator returns sensitivities.

        Returns
        -------
        TwoStep
            Simulator at the two inner steps of this factory.
        """
        simulator = KernelSimulator(equations, compile_kernel(equations, many=many, tangent=tangent))
        return TwoStep(simulator.with_step(self.step), simulator.with_step(max(self.step, self.coarse)), self.sketch)
