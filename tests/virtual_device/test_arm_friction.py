"""The arm with a friction law per joint against SciPy's DOP853, stick and slip of Maxwell elements by its events."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.machine.joint import integrate
from haptid.virtual_device.machine.truth import DRIVE, read_truth
from haptid.virtual_device.recording.inputs import AMPLITUDE

ALL = tuple(range(JOINTS))
N = 6
T = np.arange(61) * 0.005
U = np.array(AMPLITUDE) * (
    np.cos(np.outer(T, 8.0 + np.arange(JOINTS))) + 0.4 * np.cos(np.outer(T, 31.0 + np.arange(6)))
)
MIXED = {1: "maxwell_slip", 2: "dahl", 4: "maxwell_slip"}


def arm_with(friction: dict[int, str]) -> Arm:
    return Arm(replace(read_truth(), friction=friction))


class ByHand:
    """The arm's joints under friction written once more: state q, v, then six places a joint."""

    def __init__(self, arm: Arm) -> None:
        self.arm, self.law = arm, [arm.truth.friction.get(j, "lugre") for j in ALL]
        self.p = dict(zip(DRIVE, arm.truth.drives.T, strict=True))
        self.elements = [j for j in ALL if self.law[j] == "maxwell_slip"]
        falling = 2.0 ** -np.arange(N)
        self.k = np.outer(self.p["sigma0"], falling / falling.sum())
        self.way = np.zeros((JOINTS, N))

    def level(self, j: int, v: float) -> float:
        p = self.p
        return float(p["Fc"][j] + (p["Fs"][j] - p["Fc"][j]) * np.exp(-((v / p["vs"][j]) ** 2)))

    def friction(self, j: int, v: float, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the torque of joint j and the rates of its six places."""
        sigma0, sigma1, sigma2, Fc = (self.p[id][j] for id in ("sigma0", "sigma1", "sigma2", "Fc"))
        if self.law[j] == "maxwell_slip":
            slips = self.way[j] * 40.0 * Fc * (1 / N - np.abs(x) / self.level(j, v))
            return x.sum() + sigma2 * v, np.where(self.way[j] == 0, self.k[j] * v, slips)
        if self.law[j] == "dahl":
            return sigma0 * x[0] + sigma2 * v, np.array([v - sigma0 * abs(v) / Fc * x[0], *[0.0] * (N - 1)])
        bristle = v - sigma0 * abs(v) / self.level(j, v) * x[0]
        return sigma0 * x[0] + sigma1 * bristle + sigma2 * v, np.array([bristle, *[0.0] * (N - 1)])

    def rates(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        q, v, inner = x[:6], x[6:12], x[12:].reshape(JOINTS, N)
        M, h = self.arm.dynamics(q, v)
        made = [self.friction(j, v[j], inner[j]) for j in ALL]
        spring = self.p["Ks"] * (q - self.p["epos"])
        a = np.linalg.solve(M, u - h - spring - [force for force, _ in made])
        return np.concatenate([v, a, *[rates for _, rates in made]])

    def changes(self) -> list[Callable[[float, np.ndarray], float]]:
        """Return roots: a joint with elements turns; then a sticking element reaches its limit as it moves."""
        found = [lambda _, x, j=j: x[6 + j] for j in self.elements]
        for j, i in zip(*np.nonzero(self.way == 0), strict=True):
            if j in self.elements:
                found.append(lambda _, x, j=j, i=i: np.sign(x[6 + j]) * x[12 + N * j + i] - self.level(j, x[6 + j]) / N)
        for n, event in enumerate(found):
            event.terminal, event.direction = True, int(n >= len(self.elements))
        return found

    def step(self, a: float, b: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        while b - a > 1e-12:
            done = solve_ivp(
                lambda _, x: self.rates(x, u), (a, b), x, "DOP853", rtol=1e-10, atol=1e-13, events=self.changes()
            )
            a, x = done.t[-1], done.y[:, -1].copy()
            if done.status != 1:
                break
            for n, j in enumerate(self.elements):
                if done.t_events[n].size:  # the joint turns: from now on it goes the way it accelerates
                    self.way[j] = 0
                    x[6 + j] = np.sign(self.rates(x, u)[6 + j]) * 1e-12
            for j in self.elements:
                v, own = x[6 + j], x[12 + N * j : 12 + N * (j + 1)]
                hits = (self.way[j] == 0) & (own * np.sign(v) >= self.level(j, v) / N - 1e-11)
                self.way[j][hits] = np.sign(v)
        return x


def moved(arm: Arm, max_step: float) -> np.ndarray:
    """Positions (61, 6) of the arm under U."""
    state, rows = arm.start(arm.rest(ALL, np.zeros(JOINTS))), []
    for u in U:
        rows.append(state[:6].copy())
        arm.advance(ALL, state, u, 0.005, max_step=max_step)
    return np.array(rows)


@pytest.mark.parametrize(
    ("friction", "tolerances"),
    [({2: "dahl", 5: "dahl"}, (3e-8, 1e-9)), (MIXED, (5e-6, 1e-6))],
    ids=["one state each", "with elements"],
)
def test_the_arm_agrees_with_scipy_and_events(friction: dict[int, str], tolerances: tuple[float, float]) -> None:
    """A step passes over the kink of |v|, and finds elements slipping at its end: the distance falls with the step."""
    arm = arm_with(friction)
    by_hand, x = ByHand(arm), np.concatenate([arm.rest(ALL, np.zeros(JOINTS)), np.zeros(6 + N * JOINTS)])
    expected, partly = [x[:6]], 0
    for (a, b), u in zip(pairwise(T), U[:-1], strict=True):
        x = by_hand.step(a, b, x, u)
        slipping = by_hand.way[by_hand.elements] != 0
        partly += bool(np.any(slipping.any(axis=1) & ~slipping.all(axis=1)))
        expected.append(x[:6])
    assert np.all(np.ptp(expected, axis=0) > 0.01)
    assert partly > 5 or "maxwell_slip" not in friction.values()  # some stick while others slip
    for step, tolerance in zip((5e-5, 2e-5), tolerances, strict=True):
        np.testing.assert_allclose(moved(arm, step), expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("law", ["dahl", "maxwell_slip"])
def test_arm_with_one_joint_free_is_the_single_joint_under_every_law(law: str) -> None:
    joint, t = 4, np.arange(201) * 0.005
    arm, posture = arm_with({joint: law}), np.array([0.1, -0.2, 0.15, 0.3, -0.1, 0.25])
    torque = AMPLITUDE[joint] * np.cos(2.0 * t)
    state = arm.start(arm.rest((joint,), posture))
    positions = [state[joint]]
    for u in torque[:-1]:
        arm.advance((joint,), state, np.where(np.arange(JOINTS) == joint, u, 0.0), 0.005, max_step=2.5e-5)
        positions.append(state[joint])
    start = (positions[0], 0.0)
    alone = integrate(arm.locked_joint(joint, posture), t, torque, start=start, max_step=2.5e-5)[0]
    np.testing.assert_allclose(positions, alone, atol=1e-8)


def test_a_state_of_another_length_is_refused() -> None:
    arm = arm_with({})
    with pytest.raises(ValueError, match=r"shape \(84,\), got \(18,\)"):
        arm.advance(ALL, np.zeros(18), np.zeros(JOINTS), 0.005)
