"""Energy: what the bristle stores and what friction takes (Barabanov and Ortega 2000), for any parameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

from haptid.model.equations.equations import Output
from haptid.model.friction.law import Levels
from haptid.model.friction.lugre import lugre
from haptid.model.kernel.compiled import CompiledKernel
from tests.model.kernel_cases import BASE, JOINT, TENDON, draw

SYMBOLS = sp.symbols("v z sigma0 sigma1 sigma2 vs Fs Fc", real=True)
LAW = lugre(SYMBOLS[0], {s.name: s for s in SYMBOLS[2:]}, Levels())
evaluate = sp.lambdify(SYMBOLS, (*LAW.rhs, *LAW.rates, LAW.force), "math")


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(np.log10(low), np.log10(high)).map(lambda x: 10.0**x)


sizes = {
    "sigma0": decades(1e-2, 1e4), "sigma1": decades(1e-5, 1.0), "sigma2": decades(1e-5, 1.0), "vs": decades(1e-3, 1.0),
    "Fc": decades(1e-4, 1.0),
}  # fmt: skip
friction = st.fixed_dictionaries({**sizes, "ratio": st.floats(1.0, 5.0)}).map(
    lambda d: {k: v for k, v in d.items() if k != "ratio"} | {"Fs": d["ratio"] * d["Fc"]}
)
speed = st.floats(-10.0, 10.0)
load = st.floats(-1.0, 1.0)
"""Bristle torque σ0·z over Fs."""


@given(p=friction, v=speed, share=load)
def test_the_bristle_never_gives_more_than_it_stored(p: dict[str, float], v: float, share: float):
    z = share * p["Fs"] / p["sigma0"]
    rise = evaluate(v, z, **p)[0]
    assert z * rise <= z * v + 1e-12 * abs(z * v)


@given(p=friction, v=speed, excess=st.floats(1.0, 10.0), sign=st.sampled_from([-1.0, 1.0]))
def test_beyond_stiction_the_bristle_relaxes(p: dict[str, float], v: float, excess: float, sign: float):
    z = sign * excess * p["Fs"] / p["sigma0"]
    assert z * evaluate(v, z, **p)[0] <= 1e-12 * abs(z * v)


@given(p=friction, v=speed, share=load)
def test_passive_where_viscous_friction_outweighs_the_stribeck_slope(p: dict[str, float], v: float, share: float):
    assume(p["sigma2"] > p["sigma1"] * (p["Fs"] - p["Fc"]) / p["Fc"])
    z = share * p["Fs"] / p["sigma0"]
    rise, _, force = evaluate(v, z, **p)
    supplied, stored = force * v, p["sigma0"] * z * rise
    assert supplied - stored >= -1e-9 * (abs(supplied) + abs(stored))


@given(p=friction, v=speed.filter(lambda v: abs(v) > 1e-6))
def test_sliding_at_constant_speed_gives_the_stribeck_curve(p: dict[str, float], v: float):
    g = p["Fc"] + (p["Fs"] - p["Fc"]) * np.exp(-((v / p["vs"]) ** 2))
    steady = np.sign(v) * g / p["sigma0"]
    rise, rate, force = evaluate(v, steady, **p)
    assert abs(rise) < 1e-9 * abs(v)
    assert rate >= 0
    np.testing.assert_allclose(force, np.sign(v) * g + p["sigma2"] * v, rtol=1e-6)


def stored_energy() -> sp.Expr:
    """½Mv² + ½Ks(q − epos)² + ½σ0·z² + g_c·sin q − g_s·cos q."""
    s = {x.id: x.symbol for x in (*JOINT.states, *JOINT.parameters)}
    spring = s["Ks"] * (s["q"] - s["epos"]) ** 2 / 2
    gravity = s["gravity_cos"] * sp.sin(s["q"]) - s["gravity_sin"] * sp.cos(s["q"])
    return s["inertia"] * s["v"] ** 2 / 2 + spring + s["sigma0"] * s["z"] ** 2 / 2 + gravity


def test_a_joint_left_alone_only_loses_energy():
    energy = Output(id="E", unit="J", description="stored energy", expression=stored_energy())
    kernel = CompiledKernel.of(replace(JOINT, name="joint4_energy", outputs=(*JOINT.outputs, energy)), tangent=False)
    t = np.arange(0.0, 3.0, 0.002)
    for nominal in (TENDON, BASE):
        P = draw(nominal, 100, seed=21)
        x0 = np.column_stack((np.full(100, 0.3), np.full(100, 0.5), np.zeros(100)))
        E = kernel.simulate_many(t, np.zeros((t.size, 1)), P, x0)[..., 1]
        span = E.max(axis=1) - E.min(axis=1)
        assert np.all(span > 0)
        assert np.all(np.diff(E, axis=1).max(axis=1) < 1e-6 * span)
