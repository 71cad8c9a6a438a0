"""Simulators of a joint with effects, compiled once per process and formula, at the longest accurate step."""

from __future__ import annotations

from dataclasses import dataclass

from identification.kernel_simulator import KernelSimulator
from model.equations import Equations
from model.kernel.compiled import CompiledKernel
from model.observer import with_observer

STEP = 2.5e-3
"""Longest inner step of the search [s]; `discrepancy.steps` checks it against a finer one."""
_compiled: dict[tuple[str, bool, float], CompiledKernel] = {}


def compiled(equations: Equations, *, observed: bool = False, step: float = STEP) -> CompiledKernel:
    """Return the kernel of ``equations``, with output injection where ``observed``."""
    key = (equations.digest, observed, step)
    if key not in _compiled:
        _compiled[key] = CompiledKernel.of(with_observer(equations) if observed else equations, step=step)
    return _compiled[key]


@dataclass(frozen=True, slots=True)
class Factory:
    """From equations to a simulator: what the search is handed in place of a concrete one."""

    step: float = STEP

    def __call__(self, equations: Equations, *, observed: bool = False) -> KernelSimulator:
        """Build the simulator; without ``observed`` it runs at observer gain 0 alone and compiles faster."""
        plain = compiled(equations, step=self.step)
        return KernelSimulator(
            equations, plain, compiled(equations, observed=True, step=self.step) if observed else plain
        )
