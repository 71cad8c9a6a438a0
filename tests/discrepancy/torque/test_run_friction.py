"""Friction that differs from run to run is told and taken out; a speed curve, cogging or one odd run is not it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit, fit_model
from haptid.discrepancy.torque.run_friction import even_out_friction
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.discrepancy.torque_search.search import search_torque
from haptid.identification.simulators.inverse_dynamics import torque_runs
from haptid.identification.simulators.slow_rows import Mask
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.support.linear_algebra import rms
from haptid.support.listener import ignore_progress
from tests.discrepancy.torque.test_torque import BASE

LEVELS = (1.3, 1.15, 1.05, 0.95, 0.9)
PERIODS = (5.0, 3.0, 6.0, 4.0, 3.5)
FITTED = 3
Torque = Callable[[np.ndarray, np.ndarray], np.ndarray]


def friction(v: np.ndarray) -> np.ndarray:
    return np.asarray(0.03 * np.tanh(v / 0.005) + 0.02 * v)


def study(torque: Torque, levels: Sequence[float] = LEVELS, sealed: float | None = None) -> TorqueStudy:
    """Triangle sweeps at several speeds, the last ones held out, with white noise of 1 mN m in the torque."""
    rng = np.random.default_rng(3)
    runs = []
    for k, (level, period) in enumerate(
        zip([*levels, *([] if sealed is None else [sealed])], (*PERIODS, 4.5), strict=False)
    ):
        t = np.arange(0.0, 20.0, 0.01)
        q = 1.0 - np.abs((t / period) % 2.0 - 1.0)
        q = np.convolve(np.pad(q, 20, mode="edge"), np.ones(41) / 41, mode="valid")
        v = np.gradient(q, t)
        tau = 0.04 * (q - 0.3) + level * friction(v) + torque(q, v) + 1e-3 * rng.standard_normal(t.size)
        runs.append(
            Run(
                t=t, u=tau[:, None], y=q[:, None], noise=np.array([1e-6]), resolution=np.array([0.0]), free_joints=(4,),
                use="fit" if k < FITTED else "validate", file=f"run{k}.csv", posture=np.zeros(1), hold="linear",
            )
        )  # fmt: skip
    turned = torque_runs(runs, 0.0)
    known = {"gravity_cos": {"fixed": True}, "gravity_sin": {"fixed": True}, "Kp": {"fixed": True}}
    guesses = {"Ks": {"initial": 0.03}, "sigma0": {"initial": 3.0}, "Fc": {"initial": 0.02}, "Fs": {"initial": 0.03}}
    last = len(levels)
    seen: list[Mask] = [np.full(run.t.shape, run.use == "fit") for run in turned[:last]]
    return TorqueStudy(
        joint=4, runs=turned[:last], seen=tuple(seen), base=BASE.with_parameters(known | guesses), prismatic=False,
        sealed=turned[last:],
    )  # fmt: skip


def nothing(q: np.ndarray, _: np.ndarray) -> np.ndarray:
    return np.zeros_like(q)


def evened(torque: Torque, levels: Sequence[float] = LEVELS, sealed: float | None = None) -> TorqueFit | None:
    return even_out_friction(fit_model(study(torque, levels, sealed), starts=1))


def test_levels_of_a_joint_that_warms_up_are_those_of_its_runs():
    found = evened(nothing, sealed=1.2)
    assert found is not None
    told = found.study.friction_by_run
    assert told is not None
    assert told.after < 0.4 * told.before
    mean = np.mean([told.levels[f"run{k}.csv"] for k in range(FITTED)])
    for k, level in enumerate((*LEVELS, 1.2)):
        assert told.levels[f"run{k}.csv"] / mean == pytest.approx(level / np.mean(LEVELS[:FITTED]), rel=0.02)
    assert rms(found.fitted) < 1.5e-3
    assert rms(found.unseen) < 1.5e-3
    # Rows that gave a level are scored no more.
    held_out = found.study.unseen_rows[FITTED]
    first = round(THRESHOLDS.torque.part_that_gives_friction * held_out.size)
    assert not held_out[: first - 1].any()
    assert held_out[first + 1 :].any()


@pytest.mark.parametrize(
    "torque",
    [
        nothing,
        lambda q, _: 0.01 * np.sin(9.0 * q),
        lambda _, v: 0.08 * v * np.abs(v),
        lambda _, v: 0.02 * np.tanh(v / 0.005) * np.exp(-((v / 0.25) ** 2)),
    ],
    ids=["nothing", "cogging", "drag", "stribeck"],
)
def test_the_same_friction_in_every_run_is_left_as_it_is(torque: Torque):
    assert evened(torque, levels=(1.0,) * 5) is None


def test_two_runs_have_no_friction_of_their_own():
    few = study(nothing, levels=LEVELS[2:4])
    few_seen = (few.seen[0], np.zeros_like(few.seen[1]))
    model = fit_model(TorqueStudy(joint=4, runs=few.runs, seen=few_seen, base=few.base, prismatic=False))
    assert even_out_friction(model) is None


def test_friction_over_position_is_named_behind_friction_of_each_run():
    """A warming harmonic drive with two bad spots was `unlisted`: no name closed any of 1.8 N m."""

    def spot(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.asarray(0.008 * np.sin(9.0 * q + 0.5) * np.tanh(v / 0.005))

    keys = ("position_dependent_friction:wave", "cubic_spring", "quadratic_drag")
    found = search_torque(study(spot), {key: catalogue()[key] for key in keys}, starts=1, seed=0, tell=ignore_progress)
    assert found.study.friction_by_run is not None
    assert [e.id for e in found.final.effects] == ["position_dependent_friction"]
    assert rms(found.final.unseen) < 0.5 * rms(found.base.unseen)
