"""Which fit gives the whole device a joint's springs and friction, and what consistent links move."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.identification.result.fit import Combination
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence import whole_device
from tests.identification.sequence.test_carry import fit_of


def step_of(outcome: Outcome, *joints: int) -> Any:
    return SimpleNamespace(fit=SimpleNamespace(outcome=outcome), configuration=SimpleNamespace(free_joints=joints))


@pytest.mark.parametrize(
    ("last", "Fc"), [(Outcome.LONELY, 0.12), (Outcome.ABOVE_NOISE, 0.12), (Outcome.CONVERGED, 0.13)]
)
def test_a_fit_above_the_noise_does_not_replace_one_at_it(
    last: Outcome, Fc: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Joints that moved together, at 74 times the noise, gave the device a stiction that each alone had not."""
    steps = [step_of(Outcome.CONVERGED, 0), step_of(last, 0, 1)]
    values = {(0,): {"Fc": 0.12}, (0, 1): {"Fc_0": 0.13, "Fc_1": 0.2}}
    monkeypatch.setattr(whole_device, "_condition_on", lambda step, *_: values[step.configuration.free_joints])
    found = whole_device._joints(steps, [None, None], np.zeros(1), None)  # type: ignore[list-item] # not read
    assert found == {"Fc_0": Fc, "Fc_1": 0.2}


@pytest.mark.parametrize(
    ("status", "combined", "moves"),
    [("identified", False, True), ("unidentifiable", False, False), ("unidentifiable", True, True)],
)
def test_consistent_links_move_what_the_runs_tell_alone(status: str, combined: bool, moves: bool) -> None:
    fit = fit_of((4,), np.array([q.initial for q in _equations()]), np.eye(len(_free())))
    place, with_it = fit.free.index("inertia"), fit.free.index("Fs")
    covariance = np.diag(np.square(0.1 * np.array([max(abs(fit.values[id]), 1e-3) for id in fit.free])))
    covariance[place, with_it] = covariance[with_it, place] = 0.8 * np.sqrt(
        covariance[place, place] * covariance[with_it, with_it]
    )
    combinations = (Combination(coefficients={"Fs": 1.0, "Ks": 0.5}, value=1.0, std=0.1),) if combined else ()
    statuses = dict.fromkeys(fit.free, "identified") | {"Fs": status}
    step: Any = SimpleNamespace(fit=fit.but(covariance=covariance, statuses=statuses, combinations=combinations))
    one: Any = SimpleNamespace(coefficients=(SimpleNamespace(id="inertia"),), rows=np.eye(1))
    heavier = np.array([1.1 * fit.values["inertia"]])
    found = whole_device._condition_on(step, one, heavier, None)
    assert (found["Fs"] > 1.005 * fit.values["Fs"]) is moves
    assert found["Ks"] == pytest.approx(fit.values["Ks"])


def _equations() -> Any:
    return fit_of((4,), np.zeros(1), np.eye(1)).equations.parameters


def _free() -> list[str]:
    return [q.id for q in _equations() if not q.fixed]
