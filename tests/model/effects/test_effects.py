"""Every effect of the catalogue: neutral at zero, differentiable, of the stated dimensions, the same as an FMU."""

from __future__ import annotations

import re
from dataclasses import asdict, replace
from functools import cache
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from haptid.fmu_build.building.packaging import Kind, build_fmu
from haptid.model.effects.effect import a as acceleration_symbol
from haptid.model.effects.effect import coulomb, match_parameters, t, v, w
from haptid.model.effects.effect import q as position_symbol
from haptid.model.effects.registry import catalogue, load_folder
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.kernel.printing import check_functions, slopes
from haptid.support.installing.environment import ROOT
from tests.fmu_build.fmu_cases import Client
from tests.model.kernel_cases import CASES, KERNEL, TENDON, torque, vector

ENTRIES = {key: e for key, e in catalogue().items() if not e.random}
AMPLITUDE = CASES["tendon"][1]
T = np.arange(0.0, 4.0, 0.01)
U = torque(T, AMPLITUDE)
START = (0.1, 0.02, 1e-4)
STEP = 2.5e-4
BASE = KERNEL.simulate(T, U, vector(TENDON), np.array(START), step=STEP)[:, 0]
SCALES = Scales(
    torque=float(np.abs(U).max()), position=float(np.ptp(BASE)) / 2, centre=float(BASE.max() + BASE.min()) / 2,
    speed=float(np.abs(np.gradient(BASE, T)).max()), inertia=TENDON["inertia"], friction=TENDON["Fc"],
    viscous=TENDON["sigma2"], duration=float(T[-1]),
)  # fmt: skip
LOOSE = {"backlash:motor": 0.05}
"""Relative tolerance of derivatives where the motion hits a wall; 0.02 elsewhere."""
FIXED_RATE = {"backlash:encoder": 1e-5, "amplifier_lag:settled": 1e-4, "clock_error": 1e-6}
"""The play's wall, the lag's settling at the start, the lags that see the torque's slope: rates fixed in 1/s, and how
far that shows [rad]."""


@cache
def equations(key: str) -> Equations:
    return joint_equations(4, effects=[ENTRIES[key].at(SCALES)])


@cache
def kernel(key: str) -> CompiledKernel:
    return CompiledKernel.of(equations(key))


def point(key: str, **changes: float) -> np.ndarray:
    values = {q.id: q.initial for q in equations(key).parameters} | TENDON | changes
    return np.array([values[q.id] for q in equations(key).parameters])


def start(key: str) -> np.ndarray:
    return np.array([*START, *(s.start for s in equations(key).states[3:])])


def simulated(key: str, p: np.ndarray, t: np.ndarray = T, u: np.ndarray = U, step: float = STEP) -> np.ndarray:
    return kernel(key).simulate(t, u, p, start(key), step=step)[:, 0]


@pytest.mark.parametrize("key", ENTRIES)
def test_at_zero_it_is_the_base_model(key: str):
    neutral = simulated(key, point(key, **ENTRIES[key].neutral))
    np.testing.assert_allclose(neutral, BASE, rtol=0, atol=1e-12)


@pytest.mark.parametrize("key", ENTRIES)
def test_at_its_typical_size_it_shows(key: str):
    moved = simulated(key, point(key)) - simulated(key, point(key, **ENTRIES[key].neutral))
    assert np.isfinite(moved).all()
    assert 1e-6 < np.sqrt(np.mean(moved**2)) < 0.2


@pytest.mark.parametrize("key", ENTRIES)
def test_derivatives_equal_differences(key: str):
    e, p = equations(key), point(key)
    dy = kernel(key).simulate_tangent(T, U, p, start(key), step=STEP)[1][:, 0]
    for i, q in enumerate(e.parameters):
        if q.id in TENDON or q.fixed:
            continue
        h = 1e-4 * (abs(p[i]) or 1.0)  # a phase may start at 0, where a share of it is no step
        moved = [p.copy() for _ in range(4)]
        for vary, steps in zip(moved, (1, -1, 2, -2), strict=True):
            vary[i] += steps * h
        y = [simulated(key, each) for each in moved]
        reference = (8 * (y[0] - y[1]) - (y[2] - y[3])) / (12 * h)
        error = np.sqrt(np.mean((dy[:, i] - reference) ** 2) / (np.mean(reference**2) + 1e-30))
        assert error < LOOSE.get(key, 0.02), (q.id, error)


def mass_and_time(unit: str) -> tuple[int, int]:
    """Exponents of mass and time in a unit such as ``N m s^2/rad^2``."""
    total = [0, 0]
    above, _, below = unit.partition("/")
    for part, sign in ((above, 1), (below.strip("()"), -1)):
        for name, power in re.findall(r"(kg|N|rad|m|s)(?:\^(\d))?(?![a-z])", part):
            n = sign * int(power or 1)
            mass, time = {"kg": (1, 0), "N": (1, -2), "s": (0, 1)}.get(name, (0, 0))
            total[0] += n * mass
            total[1] += n * time
    return total[0], total[1]


def in_other_units(key: str, mass: float, time: float) -> np.ndarray:
    factors = [mass**m * time**s for m, s in (mass_and_time(q.unit) for q in equations(key).parameters)]
    return point(key) * np.array(factors)


@pytest.mark.parametrize("key", ENTRIES)
def test_the_stated_units_are_those_of_the_formula(key: str):
    """The same motion in another unit of mass: all parameters rescaled by their stated units, torque likewise."""
    reference = simulated(key, point(key))
    other = simulated(key, in_other_units(key, 1000.0, 1.0), u=1000.0 * U)
    np.testing.assert_allclose(other, reference, rtol=0, atol=1e-9)


@pytest.mark.parametrize("key", ENTRIES)
def test_the_stated_units_of_time_are_those_of_the_formula(key: str):
    """The same motion in another unit of time, 1.25 times as long in numbers."""
    x = start(key)
    for i, s in enumerate(equations(key).states):
        x[i] *= 1.25 ** mass_and_time(s.unit)[1]
    p = in_other_units(key, 1.0, 1.25)
    other = kernel(key).simulate(1.25 * T, 1.25**-2 * U, p, x, step=1.25 * STEP)[:, 0]
    np.testing.assert_allclose(other, simulated(key, point(key)), rtol=0, atol=FIXED_RATE.get(key, 1e-7))


def test_beside_a_clock_that_is_off_the_others_live_by_the_machines_time():
    """Readings at the clock's rate 1 + ε are those of the machine at the stretched times."""
    rate, frequency = 1.02, 30.0
    own = {"disturbance_sin": 2e-3, "disturbance_cos": 1e-3, "disturbance_frequency": frequency}
    pair = joint_equations(4, effects=[ENTRIES["clock_error"], ENTRIES["periodic_disturbance"]])
    alone = joint_equations(4, effects=[ENTRIES["periodic_disturbance"]])
    values = TENDON | own | {"clock_rate": rate - 1.0}
    still = np.zeros_like(U)
    y = {
        e: CompiledKernel.of(e).simulate(
            t, still, np.array([values[q.id] for q in e.parameters]),
            np.array([*START, *(s.start for s in e.states[3:])]), step=STEP,
        )[:, 0]
        for e, t in ((pair, T), (alone, rate * T))
    }  # fmt: skip
    np.testing.assert_allclose(y[pair], y[alone], rtol=0, atol=1e-6)
    assert np.ptp(y[alone]) > 1e-3


@pytest.mark.parametrize(("rate", "share"), [(0.99, 1e-3), (0.996, 1e-3), (1.004, 1e-3), (1.01, 5e-3)])
def test_a_clock_that_is_off_drives_the_machine_by_the_torque_of_its_own_time(rate: float, share: float):
    """The readings are those of the joint at (1 + ε)·t under τ((1 + ε)·t), but for a small share of what ε does.

    A torque that is held from sample to sample and looked ahead at by 0.16 s shows its steps.
    """
    times = np.arange(0.0, 16.0, 0.01)
    off = simulated("clock_error", point("clock_error", clock_rate=rate - 1.0), u=torque(times, AMPLITUDE), t=times)
    x0, p = np.array(START), vector(TENDON)
    plain = KERNEL.simulate(times, torque(times, AMPLITUDE), p, x0, step=STEP)[:, 0]
    stretched = KERNEL.simulate(rate * times, torque(rate * times, AMPLITUDE), p, x0, step=STEP)[:, 0]
    assert np.std(off - stretched) < share * np.std(plain - stretched)


def test_effects_take_their_place_in_the_chain_whatever_the_order():
    dead_band, ripple, payload = (
        ENTRIES[key].at(SCALES) for key in ("amplifier_dead_band:jump", "torque_ripple", "payload_gravity")
    )
    first = joint_equations(4, effects=[dead_band, ripple, payload])
    second = joint_equations(4, effects=[payload, ripple, dead_band])
    assert list(map(str, first.rhs)) == list(map(str, second.rhs))


def test_a_jump_is_sharpened_step_by_step():
    effect = ENTRIES["amplifier_dead_band:jump"].at(SCALES)
    widths = []
    while effect is not None:
        widths.append(next(q.initial for q in effect.parameters if q.id == effect.edge))
        effect = effect.sharper
    assert widths == [0.3, 0.1, 0.03, 0.01, 0.002, 5e-4, 1e-4]
    assert ENTRIES["torque_ripple"].sharper is None


@pytest.mark.parametrize("key", catalogue())
def test_the_table_of_an_entry_makes_sense(key: str):
    e = catalogue()[key].at(SCALES)
    for q in e.parameters:
        assert q.lower <= q.initial <= q.upper
        assert q.lower < q.upper
        assert q.description
        assert q.unit
    for q in e.parameters[: e.amplitudes]:
        assert q.lower <= 0.0 < q.initial, f"{q.id} cannot vanish, or has no size to start from"
    known = {q.id: q for q in e.parameters}
    for id, grid in e.shapes:
        assert all(known[id].lower <= value <= known[id].upper for value in grid)
    assert set(e.rivals) <= {other.id for other in catalogue().values()} - {e.id}


@pytest.mark.parametrize(
    ("key", "kind"),
    [
        ("cubic_spring", "native"), ("time_delay", "native"), ("backlash:encoder", "native"),
        ("amplifier_saturation:hard", "native"), ("lock_compliance", "python"), ("coulomb_drift", "python"),
    ],
)  # fmt: skip
def test_an_fmu_moves_like_the_kernel(tmp_path: Path, key: str, kind: Kind):
    t, values = T[:151], dict(zip([q.id for q in equations(key).parameters], point(key), strict=True))
    made = build_fmu(equations(key), tmp_path / "effect.fmu", kind=kind, values=values)
    x0 = [s.start for s in equations(key).states]
    expected = kernel(key).simulate(t, U[:151], point(key), x0)[:, 0]
    moved = Client(made).start().go().run(equations(key), t, U[:151])[:, 0]
    np.testing.assert_allclose(moved, expected, rtol=0, atol=1e-12)


def test_the_example_of_the_how_to_is_an_entry(tmp_path: Path):
    text = (ROOT / "docs" / "how-to" / "find_missing_physics.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (tmp_path / "seal.py").write_text(code, encoding="utf-8")
    (loaded,) = load_folder(tmp_path).values()
    effect = loaded.at(SCALES)
    k = CompiledKernel.of(joint_equations(4, effects=[effect]))
    moved = [k.simulate(T, U, [*vector(TENDON), a], START)[:, 0] for a in (0.0, effect.parameters[0].initial)]
    np.testing.assert_allclose(moved[0], KERNEL.simulate(T, U, vector(TENDON), START)[:, 0], rtol=0, atol=1e-12)
    assert np.ptp(moved[1]) < 0.99 * np.ptp(moved[0])


@pytest.mark.parametrize("key", [key for key in ENTRIES if key.startswith("amplifier_")])
def test_beside_an_amplifier_every_entry_still_has_derivatives_that_the_kernel_knows(key: str):
    for other, effect in ENTRIES.items():
        if effect.id == ENTRIES[key].id:
            continue
        e = joint_equations(0, effects=[ENTRIES[key].at(SCALES), effect.at(SCALES)])
        expressions = [*e.rhs, *(output.expression for output in e.outputs)]
        derivatives = [d for f in expressions for d in slopes(f, [x.symbol for x in (*e.states, *e.parameters)])]
        assert not any(d.has(sp.Derivative) for d in derivatives), other
        check_functions(derivatives)


@pytest.mark.parametrize("travel", [0.1, 0.5, 2.0])
def test_an_encoders_line_that_passes_once_over_the_travel_lies_in_the_range(travel: float):
    at = ENTRIES["encoder_ripple"].at(Scales(**(asdict(SCALES) | {"position": travel / 2})))
    number = next(q for q in at.parameters if q.id == "encoder_ripple_number")
    once, finest = 2 * np.pi / travel, 2 * np.pi / (0.05 * travel)
    assert number.lower < once < number.initial < finest < number.upper


def test_the_same_equations_under_other_names_are_known_as_such():
    known = catalogue()
    names = match_parameters(known["backlash:motor"], known["tendon_slack"])
    assert names is not None
    assert names["gear_play"] == "slack_half_width"
    others = [(a, b) for a, b in combinations(known.values(), 2) if a.id != b.id]
    pairs = [(a, b) for a, b in others if match_parameters(a, b) is not None]
    assert {(a.key, b.key) for a, b in pairs} == {("backlash:motor", "tendon_slack")}


@pytest.mark.parametrize("delay", [0.0, 3e-4, 2e-3, 4e-3, 0.03])
@pytest.mark.parametrize("omega", [0.5, 5.0, 60.0])
def test_a_delay_of_any_length_turns_a_wave_by_its_phase_and_no_more(delay: float, omega: float):
    effect = catalogue()["time_delay"]
    values = {sp.Symbol("delay_time", real=True): delay}
    states = [x.state.symbol for x in effect.states]
    right = sp.Matrix([x.rhs for x in effect.states]).subs(values)
    A, B = (np.array(right.jacobian(v), dtype=float) for v in (states, [w]))
    out = sp.Matrix([effect.input]).subs(values)
    C, D = (np.array(out.jacobian(v), dtype=float) for v in (states, [w]))
    response = (C @ np.linalg.solve(1j * omega * np.eye(3) - A, B) + D).item()
    assert response == pytest.approx(np.exp(-1j * omega * delay), abs=2e-3 * max(omega * delay, 4e-3 * omega) ** 3)


LEVELS = [key for key, e in ENTRIES.items() if e.coulomb_level is not None or e.viscous_level is not None]


@pytest.mark.parametrize("key", LEVELS)
@given(position=st.floats(0.02, 3.0), centre=st.floats(-3.0, 3.0))
@settings(max_examples=20, deadline=None)
def test_friction_stays_positive_within_bounds_and_travel(key: str, position: float, centre: float):
    scales = replace(SCALES, position=position, centre=centre)
    effect = ENTRIES[key].at(scales)
    where = {
        position_symbol: tuple(np.linspace(centre - position, centre + position, 9)), v: (-scales.speed, scales.speed),
        w: (-scales.torque, scales.torque), t: (0.0, scales.duration),
    }  # fmt: skip
    where |= {x.state.symbol: (-scales.torque, scales.torque) for x in effect.states}
    where |= {coulomb: (1e-3 * scales.torque, scales.torque)}
    ends = {x.symbol: (x.initial,) if x.fixed else (x.lower, x.upper) for x in effect.parameters} | where
    for level in (effect.coulomb_level, effect.viscous_level):
        if level is not None:
            ids = sorted(level.free_symbols, key=str)
            value = sp.lambdify(ids, level)
            assert min(float(value(*corner)) for corner in product(*(ends[id] for id in ids))) >= 0.0


def test_a_locked_neighbour_is_also_an_elastic_transmission_whose_motor_is_measured():
    """A device of one joint was told of a locked neighbour, which it has not.

    Motor (1 − μ)·M at q, link μ·M at q + η, between them k = μ·M·Ω² and c = 2ζ·Ω·μ·M; the load is on the motor.
    """
    effect = ENTRIES["lock_compliance"]
    assert effect.title.startswith("second inertia behind an elastic element: an elastic transmission")
    assert "or a locked neighbour" in effect.title
    load, whole, q2, share, omega, zeta, stretch, rate = sp.symbols(
        "load inertia q2 lock_share lock_frequency lock_damping neighbour neighbour_speed", real=True
    )
    spring = share * whole * (omega**2 * stretch + 2 * zeta * omega * rate)
    alone = {acceleration_symbol: load / whole}
    assert sp.simplify((load + spring) / ((1 - share) * whole) - effect.acceleration.subs(alone)) == 0
    link = -spring / (share * whole)
    assert sp.simplify(link - q2 - effect.states[1].rhs.subs({acceleration_symbol: q2})) == 0
