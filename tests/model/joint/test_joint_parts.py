"""Effects in one of several joints: with all others at rest, the joint moves as it does alone."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from haptid.model.device.reader import load_device
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.joint_in_device import joint_part, of_the_test_alone
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.whole_device import full_equations

DEVICE = load_device("freedom6s")
JOINT = 4
SCALES = Scales(
    torque=0.02, position=0.3, centre=0.05, speed=1.0, inertia=2e-4, friction=1e-3, viscous=1e-3, duration=10.0
)
IN_THE_TEST = {"amplitude_scatter", "clock_error", "lock_compliance"}
TAKEN = {key: e for key, e in catalogue().items() if e.id not in IN_THE_TEST}


def drawn(effect: Effect, seed: int) -> tuple[Equations, dict[str, float]]:
    """Return the equations of the joint alone and a point: time, states, torque, parameters, by id."""
    rng = np.random.default_rng(seed)
    alone = joint_equations(JOINT, effects=[effect.at(SCALES)])
    point = {"t": 1.3, "q": 0.21, "v": -0.7, "z": 2e-3, "tau": 0.013}
    point |= {s.id: float(rng.normal(scale=0.02)) for s in alone.states[3:]}
    point |= {q.id: q.initial * float(rng.uniform(0.8, 1.2)) for q in alone.parameters}
    return alone, point


def at(expression: sp.Expr, point: dict[str, float]) -> float:
    symbols = {s: point[s.name] for s in sp.sympify(expression).free_symbols}
    return float(sp.sympify(expression).subs(symbols).evalf(subs={}))


@pytest.mark.parametrize("key", TAKEN)
def test_with_others_at_rest_a_joint_moves_as_it_does_alone(key: str):
    effect = TAKEN[key]
    alone, point = drawn(effect, seed=len(key))
    part = joint_part(DEVICE, JOINT, [effect.at(SCALES)])
    numbered = {name + (str(JOINT) if name in ("q", "v", "z", "tau") else f"_{JOINT}"): x for name, x in point.items()}
    numbered["t"] = point["t"]
    gravity = point["gravity_cos"] * np.cos(point["q"]) + point["gravity_sin"] * np.sin(point["q"])
    acceleration = (at(part.torque, numbered) - gravity) / (point["inertia"] + at(part.inertia, numbered))
    found = [acceleration, *(at(e, numbered) for e in (*part.friction_rhs, *part.rhs)), at(part.reading, numbered)]
    expected = [at(e, point) for e in (*alone.rhs[1:], alone.outputs[0].expression)]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
    rates = [at(e, numbered) for e in (*part.friction_rates, *part.rates)]
    np.testing.assert_allclose(rates, [at(e, point) for e in alone.rates[2:]], rtol=1e-9)
    known = {q.id for q in part.quantities}
    assert {f"{q.id}_{JOINT}" for q in effect.parameters} <= known


def test_what_belongs_to_a_test_of_one_joint_is_told():
    assert {e.id for e in catalogue().values() if of_the_test_alone(e)} == IN_THE_TEST


def test_the_tested_inertia_is_a_parameter_only_where_it_is_needed():
    names = {key: {q.id for q in joint_part(DEVICE, JOINT, [e]).quantities} for key, e in TAKEN.items()}
    assert {key for key, ids in names.items() if f"inertia_{JOINT}" in ids} == {
        "backlash:motor", "configuration_inertia", "tendon_elasticity", "tendon_slack",
    }  # fmt: skip


def test_coupled_and_whole_equations_take_effects_by_joint_along():
    effects = {0: [TAKEN["cogging"]], 1: [TAKEN["amplifier_lag:rest"], TAKEN["encoder_ripple"]]}
    coupled = configuration_equations(DEVICE, (0, 1), effects=effects)
    whole = full_equations(DEVICE, effects)
    for equations in (coupled, whole):
        assert equations.effects == ("joint0_cogging", "joint1_amplifier_lag", "joint1_encoder_ripple")
        assert {"cogging_sin_0", "lag_time_1", "encoder_ripple_cos_1"} <= {q.id for q in equations.parameters}
        assert equations.parameter("lag_time_1").structured == "joint1.amplifier_lag.lag_time"
        assert len(equations.states) == 3 * len(equations.joints) + 1
    assert len({coupled.digest, configuration_equations(DEVICE, (0, 1)).digest}) == 2
    assert replace(whole, name="").digest != replace(full_equations(DEVICE), name="").digest
