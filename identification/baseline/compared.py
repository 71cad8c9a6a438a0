"""Model and plain model on every run of a configuration: `Fit` and `Run`s in, `Compared` out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.identification.baseline.baseline import Baseline, fit_baseline
from haptid.identification.baseline.figures import Figures, Model, figures_of, torque_residual
from haptid.identification.baseline.plain_parameters import plain_theta
from haptid.identification.baseline.regressor import Regressor
from haptid.identification.baseline.torque_along import TorqueAlong
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.signals.filtered_motion import FilteredMotion, common_width, filter_run, state_width
from haptid.measurement.signals.repeats import lowest_floor
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.support.processes.threads import map_threads


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
    floor
        RMS of the torque that does not repeat [N m] or [N], shape (n_joints,), from the residual of the model that
        predicts better; NaN where too few positions and speeds are passed again.
    runs
        Runs that they were held against; where a drive makes the torque, with that torque.
    width, width_of_states
        Standard deviations [s] of the filters of the torques, and of the motion that simulations begin from.
    torque_scored
        Whether the parameters were fitted to the torque.
    """

    baseline: Baseline | None
    figures: Mapping[tuple[str, str], Mapping[str, Figures]]
    models: Mapping[str, Model]
    floor: Array
    runs: tuple[Run, ...]
    width: float
    width_of_states: float
    torque_scored: bool = False

    @property
    def delay_s(self) -> float:
        """Delay of the recorded torque behind which the plain model explains it [s]; 0 without one."""
        return 0.0 if self.baseline is None else self.baseline.delay_s

    @property
    def sliding_friction(self) -> float:
        """Dry friction of a single joint's plain model [N m] where that tells it from viscous friction, else 0.

        A sweep at one speed does not: its dry friction is all friction at that speed.
        """
        if self.baseline is None:
            return 0.0
        known = dict(zip(self.baseline.regressor.ids, np.isfinite(self.baseline.estimate.std), strict=True))
        return self.baseline.of_joint("Fc", 0) if known["Fc"] and known["Fv"] else 0.0

    def badness(self, name: str, use: str) -> float:
        """Return the mean `Figures.badness` of a model over the runs of one use.

        Parameters
        ----------
        name
            ``model`` or ``baseline``.
        use
            ``fit`` or ``validate``.

        Returns
        -------
        float
            Infinite where there is no such model or run.
        """
        return _mean([one.badness for one in self._figures_of(name, use)])

    @property
    def plain_is_better(self) -> bool:
        """Whether the plain model predicts the runs that no fit saw better than the fit.

        By torque and position together and, where the position was fitted, by the position too: along a measured motion
        its noise bends stiff bristles, whose torque is then no measure of a model that simulates the motion better.
        """
        if self.badness("baseline", "validate") >= self.badness("model", "validate"):
            return False
        plain = _mean([one.position_badness for one in self._figures_of("baseline", "validate")])
        fitted = _mean([one.position_badness for one in self._figures_of("model", "validate")])
        return self.torque_scored or plain < fitted

    def _figures_of(self, name: str, use: str) -> list[Figures]:
        """Return the figures of a model on the runs of one use."""
        return [both[name] for (_, of), both in self.figures.items() if of == use and name in both]

    def floor_json(self) -> dict[str, Any] | None:
        """Convert the floor of a configuration to the entry ``floor`` of identification.json.

        Returns
        -------
        dict or None
            ``value`` and ``unit``, one number for one joint and a list for several; None where no joint's floor is
            known.
        """
        values = [float(x) if np.isfinite(x) else None for x in self.floor]
        if all(value is None for value in values):
            return None
        slides = self.runs[0].prismatic
        units = [unit_for("N m", [one]) for one in slides]
        single = len(values) == 1
        return {"value": values[0] if single else values, "unit": units[0] if single else units}

    def as_json(self, file: str, use: str) -> dict[str, Any] | None:
        """Return ``figures`` of a run, as ``identification.json`` holds them.

        Parameters
        ----------
        file
            File of the run.
        use
            Its use.

        Returns
        -------
        dict or None
            `Figures.as_json` of ``model`` and ``baseline``; None where the run has no figures.
        """
        both = self.figures.get((file, use))
        return None if both is None else {name: one.as_json() for name, one in both.items()}


def compare(  # noqa: PLR0913 # both models, the runs, and how the runs were recorded and fitted
    equations: Equations,
    theta: Array,
    runs: Sequence[Run],
    device: Device | None,
    posture: Sequence[float],
    *,
    threads: int = 1,
    with_delay: bool = True,
    torque_scored: bool = False,
    step: float = MODEL.inner_step_s,
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
    threads
        Threads that simulate the runs side by side; the figures do not depend on their number.
    with_delay
        Whether the recorded torque may have a delay: not where it was computed along the motion.
    torque_scored
        Whether the parameters were fitted to the torque, with its delay; the position is fitted without one.
    step
        Longest inner step of the simulations [s].

    Returns
    -------
    Compared
    """
    used = [run for run in runs if run.use != "excluded"]
    first = used[0]
    regressor = Regressor.of(device, first.free_joints, posture, first.prismatic)
    inverse = TorqueAlong.of(equations, regressor, first.prismatic)
    simulator = KernelSimulator.of(equations).with_step(step)
    joints = range(len(first.free_joints))
    gain = np.array([inverse.value(theta, "Kp", k) for k in joints])
    baseline = fit_baseline(used, device, posture, gain.tolist(), with_delay=with_delay)
    delay = 0.0 if baseline is None else baseline.delay_s
    own = delay if torque_scored else 0.0
    models = {"model": Model(simulator=simulator, inverse=inverse, theta=theta, delay=own)}
    if baseline is not None:
        plain = plain_theta(baseline, equations, used)
        models["baseline"] = Model(simulator=simulator, inverse=inverse, theta=plain, baseline=baseline, delay=delay)
    width, narrow = common_width(used), state_width(used)
    motions = [filter_run(run, width) for run in used]
    starts = motions if narrow == width else [filter_run(run, narrow) for run in used]
    errors = {name: [torque_residual(model, motion) for motion in motions] for name, model in models.items()}

    def figures_on(k: int) -> dict[str, Figures]:
        return {name: figures_of(one, used[k], motions[k], errors[name][k], starts[k]) for name, one in models.items()}

    found = map_threads(figures_on, range(len(used)), threads=threads)
    figures: dict[tuple[str, str], dict[str, Figures]] = {
        (run.file, run.use): both for run, both in zip(used, found, strict=True)
    }
    size = {name: sum(float(np.sum(both[name].torque_rmse ** 2)) for both in figures.values()) for name in models}
    floor = _floor(errors[min(size, key=lambda name: size[name])], motions)
    return Compared(
        baseline=baseline,
        figures=figures,
        models=models,
        floor=floor,
        runs=tuple(used),
        width=width,
        width_of_states=narrow,
        torque_scored=torque_scored,
    )


def _mean(values: Sequence[float]) -> float:
    """Return the mean of values; infinite without any."""
    return float(np.mean(values)) if values else np.inf


def _floor(residuals: Sequence[Array], motions: Sequence[FilteredMotion]) -> Array:
    """Return the RMS of the residual torque that does not repeat, shape (n_joints,); NaN where it is unknown."""
    floor = np.full(motions[0].q.shape[1], np.nan)
    for k in range(floor.size):
        positions, speeds = ([getattr(m, of)[m.interior, k] for m in motions] for of in ("q", "v"))
        everywhere = [np.ones(q.size, dtype=bool) for q in positions]
        known = lowest_floor(positions, speeds, [e[:, k] for e in residuals], everywhere)
        floor[k] = np.nan if known is None else known
    return floor
