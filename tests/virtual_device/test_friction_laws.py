"""The other friction laws of ``joint.c`` against SciPy's Radau, stick and slip of Maxwell elements by its events."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

from haptid.measurement.format.reading import read_campaign
from haptid.support.errors import InputError
from haptid.virtual_device import make_campaign
from haptid.virtual_device.machine.friction import parse_friction
from haptid.virtual_device.machine.joint import JOINT, integrate
from haptid.virtual_device.make_campaign import main
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine, table3

P = {
    "inertia": 1.2e-4, "gravity_cos": -2e-3, "gravity_sin": 1e-3, "Kp": 1.0, "Ks": 0.02, "epos": -0.05,
    "sigma0": 0.6, "sigma2": 0.0015, "vs": 0.06, "Fs": 1.4e-3, "Fc": 1.1e-3, "C": 0.05, "spread": 2.0,
    "unevenness": 0.8, "n": 1.4,
}  # fmt: skip
N = 6
T = np.arange(241) * 0.005
U = 0.006 * np.cos(4.0 * T) + 0.002 * np.cos(13.0 * T + 1.0)


def load(q: float) -> float:
    return P["gravity_cos"] * np.cos(q) + P["gravity_sin"] * np.sin(q) + P["Ks"] * (q - P["epos"])


def solved(rates, a, b, x, events=()):
    return solve_ivp(rates, (a, b), x, "Radau", rtol=1e-10, atol=1e-13, events=events)


def test_dahl_agrees_with_radau():
    x = np.array([JOINT.rest_position(P), 0.0, 0.0])
    expected = [x[0]]
    for (a, b), u in zip(pairwise(T), U[:-1], strict=True):

        def rates(_: float, x: np.ndarray, u: float = u) -> list[float]:
            q, v, z = x
            force = u - load(q) - P["sigma0"] * z - P["sigma2"] * v
            left = 1 - P["sigma0"] * z * np.sign(v) / P["Fc"]
            return [v, force / P["inertia"], v * np.sign(left) * abs(left) ** P["n"]]

        x = solved(rates, a, b, x).y[:, -1]
        expected.append(x[0])
    q, _, _ = integrate({**P, "law": 1}, T, U, start=(expected[0], 0.0))
    assert np.ptp(expected) > 0.1
    np.testing.assert_allclose(q, expected, atol=1e-8)


class Elements:
    """Positions with sticking and slipping elements, each change found as a root."""

    def __init__(self) -> None:
        falling = P["spread"] ** -np.arange(N)
        self.k = P["sigma0"] * falling / falling.sum()
        strong = P["unevenness"] ** -np.arange(N)
        self.share = strong / strong.sum()
        self.way = np.zeros(N)

    def level(self, v: float) -> float:
        return float(P["Fc"] + (P["Fs"] - P["Fc"]) * np.exp(-((v / P["vs"]) ** 2)))

    def rates(self, x: np.ndarray, u: float) -> list[float]:
        q, v, F = x[0], x[1], x[2:]
        slips = self.way * P["C"] * (self.share - np.abs(F) / self.level(v))
        inner = np.where(self.way == 0, self.k * v, slips)
        return [v, (u - load(q) - F.sum() - P["sigma2"] * v) / P["inertia"], *inner]

    def changes(self):
        """Return roots: the speed passes 0; a sticking element reaches its limit on the side of the motion."""
        found = [lambda _, x: x[1]]
        for i in np.flatnonzero(self.way == 0):
            found.append(lambda _, x, i=i: np.sign(x[1]) * x[2 + i] - self.level(x[1]) * self.share[i])
        for event in found:
            event.terminal, event.direction = True, 1
        found[0].direction = 0
        return found

    def step(self, a: float, b: float, x: np.ndarray, u: float) -> np.ndarray:
        while b - a > 1e-12:
            done = solved(lambda _, x: self.rates(x, u), a, b, x, self.changes())
            a, x = done.t[-1], done.y[:, -1].copy()
            if done.status != 1:
                break
            if done.t_events[0].size:  # the joint turns: from now on it goes the way it accelerates
                self.way[:] = 0
                x[1] = np.sign(self.rates(x, u)[1]) * 1e-13
            v, limit = x[1], self.level(x[1]) * self.share
            hits = (self.way == 0) & (x[2:] * np.sign(v) >= limit - 1e-12)
            self.way[hits] = np.sign(v)
        return x


def test_maxwell_slip_agrees_with_radau_and_events():
    elements, x = Elements(), np.array([JOINT.rest_position(P), 0.0, *[0.0] * N])
    expected, slipped = [x[0]], 0
    for (a, b), u in zip(pairwise(T), U[:-1], strict=True):
        x = elements.step(a, b, x, float(u))
        slipped += bool(elements.way.any()) and not elements.way.all()
        expected.append(x[0])
    assert slipped > 5  # some stick while others slip
    q, _, _ = integrate({**P, "law": 2}, T, U, start=(expected[0], 0.0), max_step=1e-5)
    assert np.ptp(expected) > 0.1
    np.testing.assert_allclose(q, expected, atol=5e-6)


@pytest.mark.parametrize("friction", ["dahl", "maxwell_slip"])
def test_a_campaign_names_its_law(friction: str, tmp_path: Path):
    make_joint_campaign(tmp_path, 4, P, [Cosine(amplitude=0.005, frequency=2.0, duration=2.0)], friction=friction)
    assert read_campaign(tmp_path).friction == {4: friction}


def test_the_command_takes_a_law_for_single_joints(tmp_path: Path):
    arguments = ["--out", str(tmp_path), "--quiet", "--friction", "dahl"]
    assert CliRunner().invoke(main, [*arguments, "--joints", "4"]).exit_code == 0
    assert read_campaign(tmp_path).friction == {4: "dahl"}


def test_the_command_takes_a_law_per_joint_of_the_whole_device(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Against the embedded campaign, which has the same seed, only runs change that move joints of other laws."""
    monkeypatch.setattr(make_campaign, "table3", lambda joint: table3(joint)[:1])
    monkeypatch.setattr(make_campaign, "COUPLED", make_campaign.COUPLED[:1])
    done = CliRunner().invoke(main, ["--out", str(tmp_path), "--quiet", "--friction", "2=dahl,4=maxwell_slip"])
    assert done.exit_code == 0, done.output
    mixed, plain = read_campaign(tmp_path), {run.file: run for run in read_campaign(make_campaign.EMBEDDED).runs}
    assert mixed.friction == {2: "dahl", 4: "maxwell_slip"}
    assert {run.free_joints for run in mixed.runs} == {*((j,) for j in range(6)), (0, 1), tuple(range(6))}
    for run in mixed.runs:
        distance = np.abs(run.y - plain[run.file].y).max()
        assert (distance > 1e-3) == run.file.startswith(("joint2", "joint4", "all_joints")), run.file


@pytest.mark.parametrize(
    "friction", ["coulomb", "6=dahl", "4", "4=dahl,4=lugre", "x=dahl", "2=dahl,", "4=dahl,2=coulomb"]
)
def test_the_command_refuses_what_is_no_law_of_a_joint(friction: str, tmp_path: Path):
    done = CliRunner().invoke(main, ["--out", str(tmp_path), "--quiet", "--friction", friction])
    assert done.exit_code == 2
    assert done.output.startswith("error: --friction: expected one of lugre, dahl, maxwell_slip, or")


def test_a_law_of_a_joint_that_is_not_tested_is_refused():
    with pytest.raises(InputError, match=r"joints among 4, 5, got '2=dahl'"):
        parse_friction("4=dahl,2=dahl", (4, 5))
    assert parse_friction("4=dahl,5=lugre", (4, 5)) == {4: "dahl"}


def test_an_unknown_law_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="expected one of lugre, dahl, maxwell_slip"):
        make_joint_campaign(tmp_path, 4, P, [Cosine(amplitude=0.005, frequency=2.0)], friction="coulomb")
