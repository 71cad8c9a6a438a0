import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haptid.measurement.signals.control_detection import noise_link, position_control, steady_share
from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.values.run import Run

T = np.arange(4000) / 200.0


def run(u, y=None, t=T, **changes) -> Run:
    y = np.zeros(t.size) if y is None else y
    values = {
        "file": "a.csv", "free_joints": (4,), "t": t, "u": u[:, None], "y": y[:, None],
        "noise": [np.nan], "resolution": [np.nan], "posture": [], "use": "fit",
    }  # fmt: skip
    return Run(**{**values, **changes})


@settings(max_examples=40, deadline=None)
@given(st.floats(1.0, 40.0), st.floats(0.01, 10.0), st.floats(-1.0, 1.0))
def test_cycles_of_a_cosine(omega, amplitude, offset):
    cycles = find_cycles(run(amplitude * (np.cos(omega * T) + offset)))
    assert cycles.omega == pytest.approx(omega, rel=1e-5)
    assert cycles.share > 0.999
    whole = np.floor(omega * T / (2 * np.pi) + 1e-6).astype(int)
    last = omega * T[-1] / (2 * np.pi)
    compared = whole < np.floor(last)
    np.testing.assert_array_equal(cycles.index[compared], whole[compared])
    assert abs(cycles.count - last) <= 1


def test_a_row_just_before_a_boundary_lies_before_it_and_one_that_rounding_moved_behind_it():
    omega = 3.0  # 8 cycles end at 16.75516 s, the row before is 8e-5 of a cycle away
    index = find_cycles(run(np.cos(omega * T))).index
    row = int(16.755 * 200)
    assert index[row : row + 2].tolist() == [7, 8]
    for digits in (6, 9, 12):  # periods of 500 rows, torque as written with some digits
        u = np.round(0.01 * np.cos(2 * np.pi * T / 2.5), digits)
        assert np.flatnonzero(np.diff(find_cycles(run(u)).index)).tolist() == list(range(499, 3999, 500))


def test_index_never_falls_and_starts_at_zero():
    u = np.cos(7 * T + 1.0) + 0.3 * np.cos(11 * T)
    index = find_cycles(run(u)).index
    assert index[0] == 0
    assert set(np.diff(index)) == {0, 1}


def test_amplitudes_that_scatter_from_cycle_to_cycle_are_told_apart():
    omega = 2 * np.pi
    whole = np.floor(T + 1e-9).astype(int)
    gains = 1 + 0.05 * np.random.default_rng(0).standard_normal(21)
    u = gains[whole] * np.cos(omega * T)
    index = find_cycles(run(u)).index
    carrier = np.cos(omega * T)
    found = [u[index == k] @ carrier[index == k] / (carrier[index == k] @ carrier[index == k]) for k in range(20)]
    np.testing.assert_allclose(found, gains[:20], rtol=2e-3)


def test_a_run_of_one_and_a_half_cycles():
    cycles = find_cycles(run(np.cos(0.5 * T)))
    assert cycles.count == 2
    assert T[np.argmax(cycles.index)] == pytest.approx(4 * np.pi, abs=0.01)


def test_uneven_rows():
    t = np.cumsum(0.005 * np.random.default_rng(0).uniform(0.5, 1.5, 4000))
    t -= t[0]
    cycles = find_cycles(run(np.cos(9.0 * t), t=t))
    assert cycles.omega == pytest.approx(9.0, rel=1e-5)


@pytest.mark.parametrize("u", [np.zeros(T.size), np.random.default_rng(0).standard_normal(T.size), T])
def test_torque_that_is_not_periodic_is_one_cycle(u):
    assert find_cycles(run(u)).count == 1


def closed_loop(kp: float, kd: float, seed: int = 0) -> Run:
    """A damped inertia that a PD controller drives along a cosine, from a noisy encoder."""
    rng = np.random.default_rng(seed)
    q = v = last = 0.0
    u, y = np.zeros(T.size), np.zeros(T.size)
    for k, t in enumerate(T):
        y[k] = q + 2e-4 * rng.standard_normal()
        u[k] = kp * (0.3 * np.sin(3 * t) - y[k]) - kd * (y[k] - last) * 200
        last = y[k]
        for _ in range(5):
            v += 0.001 * (u[k] - 0.1 * v) / 0.05
            q += 0.001 * v
    return run(u, y)


def test_controller_is_betrayed_by_the_noise_in_its_torque():
    assert position_control(closed_loop(kp=5.0, kd=0.2)) == "torque follows the position's noise"


def test_open_loop_shows_no_sign_of_a_controller():
    for omega in (1.0, 5.0, 20.0):
        y = 0.3 * np.sin(omega * T - 1) + 2e-4 * np.random.default_rng(1).standard_normal(T.size)
        assert position_control(run(np.cos(omega * T), y)) == ""
        noisy = np.cos(omega * T) + 1e-3 * np.random.default_rng(2).standard_normal(T.size)
        assert noise_link(run(noisy, y), 0) < 0.1


def test_time_stamps_that_scatter_are_no_sign_of_a_controller():
    stamped = T + 3e-5 * np.random.default_rng(3).standard_normal(T.size)
    stamped -= stamped[0]
    digits, noise = (x * np.random.default_rng(seed).standard_normal(T.size) for seed, x in ((4, 1e-3), (5, 1e-6)))

    def moved(t):  # a joint without friction
        return run(10.0 * np.cos(12.0 * t) + digits, -0.1 * np.cos(12.0 * t) + noise, t=stamped)

    taken_evenly, taken_unevenly = moved(T), moved(stamped)
    assert position_control(taken_evenly) == ""
    assert position_control(taken_unevenly) == ""
    assert position_control(closed_loop(kp=5.0, kd=0.2).but(t=stamped)) == "torque follows the position's noise"


def test_triangle_sweep_is_a_sign_of_position_control():
    triangle = np.abs((T / 10) % 2 - 1)
    torque = 0.1 * np.sign(np.sin(np.pi * T / 10)) + 0.01 * np.sin(3 * T)
    measured = torque + 1e-3 * np.random.default_rng(0).standard_normal(T.size)
    assert "constant speed" in position_control(run(measured, triangle))
    assert position_control(run(torque, triangle)) == ""  # a command without noise, whatever motion it makes
    assert steady_share(T, np.zeros(T.size)) == 0


def test_recorded_reference_is_a_sign_of_position_control():
    assert "reference" in position_control(run(np.cos(T), np.sin(T), extra={"reference_4_rad": np.sin(T)}))
