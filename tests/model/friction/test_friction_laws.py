"""Every friction law: kernel against SciPy's Radau, robust over wide bounds, exact slopes, slots, devices that mix."""

from __future__ import annotations

import copy
import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import haptid.model.device.built_in
from haptid.model.device.device import Device
from haptid.model.device.device_table import parse_device
from haptid.model.device.reader import load_device
from haptid.model.effects.effect import z
from haptid.model.effects.registry import catalogue, find_effects
from haptid.model.friction.law import SLOTS, Levels
from haptid.model.friction.registry import law_named, laws
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.support.errors import InputError
from tests.model.friction_cases import AMPLITUDE, JOINT, LAWS, radau

T = np.arange(0.0, 2.0, 0.005)


@cache
def kernel(law: str) -> CompiledKernel:
    return CompiledKernel.of(joint_equations(4, friction=law))


def vector(law: str, values: dict[str, float] = JOINT) -> np.ndarray:
    return np.array([values.get(q.id, q.initial) for q in kernel(law).equations.parameters])


def rest(law: str, n: int | None = None) -> np.ndarray:
    states = len(kernel(law).equations.states)
    return np.zeros(states if n is None else (n, states))


def torque(t: np.ndarray) -> np.ndarray:
    """Two cosines, so that presliding sees reversals inside reversals."""
    return AMPLITUDE * (0.8 * np.cos(2.4 * t) + 0.4 * np.cos(11.0 * t + 1.0))


def test_laws_are_found_by_name():
    assert set(laws()) >= set(LAWS)
    with pytest.raises(InputError, match=r"expected a friction law \(.*dahl, lugre, .*\), got 'Dahl'.*dahl"):
        law_named("Dahl")


@pytest.mark.parametrize(
    ("law", "most", "least"),
    [("lugre", 3e-7, 1e-9), ("dahl", 3e-7, 1e-9), ("coulomb", 2e-5, 1e-9), ("maxwell_slip", 2e-5, 2e-7)],
)
def test_the_kernel_agrees_with_radau(law: str, most: float, least: float):
    """At the standard step to a thirtieth of a sensor's noise or better; at short steps it converges."""
    t, u = T[:161], torque(T[:161])
    expected = radau(law, JOINT, t, u)
    assert np.ptp(expected) > 0.1
    for step, tolerance in ((5e-4, most), (4e-6, least)):
        got = kernel(law).simulate(t, u[:, None], vector(law), rest(law), step=step)[:, 0]
        np.testing.assert_allclose(got, expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("law", laws())
def test_no_point_within_wide_bounds_blows_up(law: str):
    rng, n, ids = np.random.default_rng(3), 300, [q.id for q in kernel(law).equations.parameters]
    P = vector(law) * 10.0 ** rng.uniform(-2, 2, (n, len(ids)))
    for row in law_named(law).parameters:
        if row.unit == "1":  # a shape number, which is defined within its own bounds alone
            P[:, ids.index(row.id)] = rng.uniform(row.lower, row.upper, n)
    if "Fs" in ids:
        pair = [ids.index("Fs"), ids.index("Fc")]
        P[:, pair] = np.sort(P[:, pair], axis=1)[:, ::-1]
    if "sigma1" in ids:
        s1, s2, Fs, Fc = (P[:, ids.index(id)] for id in ("sigma1", "sigma2", "Fs", "Fc"))
        P[:, ids.index("sigma2")] = np.maximum(s2, 1.01 * s1 * (Fs - Fc) / Fc)
    y = kernel(law).simulate_many(T, torque(T)[:, None], P, rest(law, n))
    assert np.isfinite(y).all()


@pytest.mark.parametrize("law", ["dahl", "maxwell_slip"])
@pytest.mark.parametrize("sigma0", [1e3, 1e5, 1e7])
def test_very_stiff_friction_tends_to_a_limit(law: str, sigma0: float):
    """Ever stiffer bristles stick ever harder: what is left is sliding."""
    stiff, soft = (
        kernel(law).simulate(T, torque(T)[:, None], vector(law, JOINT | {"sigma0": s}), rest(law))[:, 0]
        for s in (sigma0, 1e2)
    )
    assert np.abs(stiff - soft).max() < 2e-2


@pytest.mark.parametrize("law", laws())
def test_sensitivities_are_those_of_the_simulation(law: str):
    k, p, u = kernel(law), vector(law), torque(T)[:, None]
    _, dy = k.simulate_tangent(T, u, p, rest(law), step=1e-4)
    for i, q in enumerate(k.equations.parameters):
        h = 1e-5 * (abs(p[i]) or 1e-3)  # less than what makes an element of Maxwell-slip turn elsewhere
        step = h * np.eye(p.size)[i]
        a, b = (k.simulate(T, u, p + s, rest(law), step=1e-4)[:, 0] for s in (step, -step))
        difference = (a - b) / (2 * h)
        scale = np.abs(difference).max()
        assert np.sqrt(np.mean((dy[:, 0, i] - difference) ** 2)) < 0.02 * scale, q.id


def test_dahl_takes_energy_and_never_gives_more_than_it_stored():
    from tests.model.friction_cases import dahl  # noqa: PLC0415

    rng = np.random.default_rng(0)
    for _ in range(200):
        v, z = rng.normal(), rng.uniform(-1.0, 1.0) * JOINT["Fc"] / JOINT["sigma0"]
        force, (rise,) = dahl(JOINT, v, np.array([z]))
        assert force * v >= JOINT["sigma0"] * z * rise - 1e-15


def test_an_effect_without_its_slot_is_refused():
    (lag,) = find_effects(["friction_lag"])
    expected = "effect friction_lag: expected a friction law with stribeck_velocity, got dahl, which has none"
    with pytest.raises(InputError, match=expected):
        joint_equations(4, effects=[lag], friction="dahl")
    joint_equations(4, effects=[lag], friction="maxwell_slip")


def test_an_effect_that_reads_the_bristle_needs_one():
    effect = catalogue()["cubic_spring"].but(torque=-z)
    assert joint_equations(4, effects=[effect], friction="dahl").effects == ("cubic_spring",)
    with pytest.raises(InputError, match="expected a friction law with bristle, got maxwell_slip, which has none"):
        joint_equations(4, effects=[effect], friction="maxwell_slip")


@pytest.mark.parametrize("law", laws())
def test_every_slot_that_a_law_offers_changes_its_torque(law: str):
    effects = {slot: [e for e in catalogue().values() if slot in e.friction_slots] for slot in SLOTS}
    plain = joint_equations(4, friction=law)
    for slot in law_named(law).slots & set(SLOTS):
        for effect in effects[slot]:
            if effect.friction_slots <= law_named(law).slots:
                assert joint_equations(4, effects=[effect], friction=law).rhs[:3] != plain.rhs[:3], effect.key


def mixed(**changes: object) -> Device:
    """Return the built-in device with joint 4 after Dahl and joint 5 after Maxwell-slip."""
    table = tomllib.loads((Path(haptid.model.device.built_in.__path__[0]) / "freedom6s.toml").read_text("utf-8"))
    table = copy.deepcopy(table)
    joints = table["joints"]
    joints[4]["friction"], joints[5]["friction"] = "dahl", "maxwell_slip"
    for id in ("sigma1", "vs", "Fs"):
        del joints[4]["parameters"][id]
    del joints[5]["parameters"]["sigma1"]
    joints[5]["parameters"] |= {"spread": 2.0, "unevenness": 0.8, "C": {"initial": 0.05, "lower": 1e-3, "upper": 5.0}}
    joints[4] |= changes
    return parse_device(table, "mixed.toml")


def test_a_device_file_names_the_law_of_a_joint():
    device = mixed()
    assert [joint.friction for joint in device.joints] == ["lugre"] * 4 + ["dahl", "maxwell_slip"]
    with pytest.raises(InputError, match=r"mixed.toml: joints\[4\].friction: expected a friction law"):
        mixed(friction="viscous")
    with pytest.raises(InputError, match=r"joints\[4\].parameters.vs: expected a parameter of a joint with dahl"):
        mixed(parameters={"vs": 0.1})


def test_one_joint_of_a_device_has_its_laws_parameters_and_guesses():
    e = configuration_equations(mixed(), [4])
    assert e.friction == ("dahl",)
    assert e.orderings == ()
    assert [s.id for s in e.states] == ["q", "v", "z"]
    assert {q.id for q in e.parameters} >= {"sigma0", "sigma2", "Fc"}
    assert not {q.id for q in e.parameters} & {"sigma1", "vs", "Fs"}


def test_joints_with_different_laws_move_together():
    device = mixed()
    pair, whole = configuration_equations(device, [4, 5]), full_equations(device)
    assert pair.friction == ("dahl", "maxwell_slip")
    assert pair.orderings == (("Fs_5", "Fc_5"),)
    assert whole.friction == ("lugre",) * 4 + ("dahl", "maxwell_slip")
    assert [s.id for s in pair.states][:6] == ["q4", "q5", "v4", "v5", "z4", "element1_5"]
    for e in (pair, whole):
        u = np.zeros((T.size, len(e.inputs)))
        for i, x in enumerate(e.inputs):
            if x.id.startswith("tau"):
                u[:, i] = 5e-3 * np.cos((1.0 + 0.3 * i) * T)
        y = CompiledKernel.of(e, many=False, tangent=False).simulate(
            T, u, [q.initial for q in e.parameters], np.zeros(len(e.states))
        )
        assert np.isfinite(y).all()
        assert np.ptp(y[:, 1]) > 0.01


def test_a_campaign_changes_the_law_of_a_joint_and_keeps_the_guesses_that_both_have():
    device = load_device("freedom6s")
    other = device.with_friction({4: "dahl"})
    assert other.joints[4].friction == "dahl"
    e = configuration_equations(other, [4])
    assert e.parameter("Fc").initial == device.joints[4].parameters["Fc"].initial


def work_of_a_cycle(values: dict[str, float], step: float = 2e-5) -> float:
    """Work [J] that Maxwell-slip friction takes in the second of two cycles: load, slip fast, creep, unload."""
    law, v = law_named("maxwell_slip"), sp.Symbol("v", real=True)
    friction = law.write(v, {id: sp.Float(value) for id, value in values.items()}, Levels())
    states = [state.symbol for state in law.states]
    rates = sp.lambdify((v, states), (friction.force, *friction.rhs), modules=["math", {"Heaviside": np.heaviside}])
    travel, slow, fast, instant = 3.0 * values["Fc"] / values["sigma0"], 0.01, 0.5, 4e-3
    legs = (
        (slow, travel / slow),
        (fast, instant),
        (1e-6, 5.0 * values["Fs"] / values["C"]),
        (-slow, (travel + fast * instant) / slow),
    )
    state = np.zeros(len(states))
    for _ in range(2):
        work = 0.0
        for speed, duration in legs:
            for _ in range(int(duration / step)):
                force, *slopes = rates(speed, state)
                work += force * speed * step
                state = state + step * np.array(slopes)
    return work


@pytest.mark.long
def test_maxwell_slip_gives_work_in_a_cycle_unless_stiction_is_coulomb_friction():
    values = {
        "sigma0": 10.0,
        "spread": 1.0,
        "unevenness": 1.0,
        "C": 2.0,
        "sigma2": 0.0,
        "vs": 0.02,
        "Fs": 0.03,
        "Fc": 0.01,
    }
    assert work_of_a_cycle(values) == pytest.approx(-2.0e-5, rel=0.05)
    assert work_of_a_cycle(values | {"Fs": 0.01}) == pytest.approx(6.0e-5, rel=0.05)
