"""Model and plain model on every run of a configuration: `Fit` and `Run`s in, `Compared` out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.identification.baseline.baseline import Baseline, fit_baseline
from haptid.identification.baseline.figures import Figures, Model, figures_of
from haptid.identification.baseline.plain_parameters import plain_theta
from haptid.identification.baseline.regressor import Regressor
from haptid.identification.baseline.torque_along import TorqueAlong
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.signals.filtered_motion import common_width, filter_run
from haptid.measurement.values.run import Array, Run
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """The plain model of a configuration, and the figures of both models by run.

    Parameters
    ----------
    baseline
        Plain model; None where the rows are too few for it.
    figures
        Figures by (file, use) and by ``model`` or ``baseline``.
    models
        The models themselves, ``model`` and ``baseline``.
    runs
        Runs that they were held against; where a drive makes the torque, with that torque.
    """

    baseline: Baseline | None
    figures: Mapping[tuple[str, str], Mapping[str, Figures]]
    models: Mapping[str, Model]
    runs: tuple[Run, ...]

    def badness(self, name: str, use: str) -> float:
        """Return the mean `Figures.badness` of a model, ``model`` or ``baseline``, over the runs of one use.

        Infinite where there is no such model or run.
        """
        values = [both[name].badness for (_, of), both in self.figures.items() if of == use and name in both]
        return float(np.mean(values)) if values else np.inf

    @property
    def plain_is_better(self) -> bool:
        """Whether the plain model predicts the runs that no fit saw better than the fit."""
        return self.badness("baseline", "validate") < self.badness("model", "validate")

    def as_json(self, file: str, use: str) -> dict[str, Any] | None:
        """Return ``figures`` of a run; None where it has none."""
        both = self.figures.get((file, use))
        return None if both is None else {name: one.as_json() for name, one in both.items()}


def compare(
    equations: Equations, theta: Array, runs: Sequence[Run], device: Device | None, posture: Sequence[float]
) -> Compared:
    """Fit the plain model and compute the figures of both models on all runs that are not excluded.

    Parameters
    ----------
    equations
        Equations of the configuration, from torque to position.
    theta
        Fitted parameters in the order of ``equations.parameters``, shape (n_p,).
    runs
        Runs of the configuration.
    device
        Device of the campaign; None for a single joint.
    posture
        Positions of the locked joints [rad].

    Returns
    -------
    Compared
    """
    used = [run for run in runs if run.use != "excluded"]
    first = used[0]
    regressor = Regressor.of(device, first.free_joints, posture, first.prismatic)
    inverse = TorqueAlong.of(equations, regressor, first.prismatic)
    simulator = KernelSimulator.of(equations)
    joints = range(len(first.free_joints))
    gain = np.array([inverse.value(theta, "Kp", k) for k in joints])
    models = {"model": Model(simulator=simulator, inverse=inverse, theta=theta)}
    baseline = fit_baseline(used, device, posture, gain.tolist())
    if baseline is not None:
        plain = plain_theta(baseline, equations, used)
        models["baseline"] = Model(simulator=simulator, inverse=inverse, theta=plain, baseline=baseline)
    figures: dict[tuple[str, str], dict[str, Figures]] = {}
    width = common_width(used)
    for run in used:
        motion = filter_run(run, width)
        figures[run.file, run.use] = {name: figures_of(model, run, motion) for name, model in models.items()}
    return Compared(baseline=baseline, figures=figures, models=models, runs=tuple(used))
