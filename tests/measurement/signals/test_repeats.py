"""The floor: what differs between passes of one position and speed, and nothing that comes back."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.measurement.signals.repeats import cell_count, cells_of, floor_of, lowest_floor

T = np.arange(0.0, 40.0, 0.01)


def motion(runs: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return positions and speeds of sweeps back and forth."""
    return [np.sin(T) for _ in range(runs)], [np.cos(T) for _ in range(runs)]


@pytest.mark.parametrize("scatter", [0.3, 3.0])
def test_scatter_between_passes_is_the_floor_whatever_repeats(scatter: float):
    positions, speeds = motion(6)
    # One offset a run: within a run six cycles repeat, between the runs nothing does.
    offsets = scatter * np.random.default_rng(0).standard_normal(6)
    signal = [np.sin(q) + np.sign(v) + o for q, v, o in zip(positions, speeds, offsets, strict=True)]
    floor = floor_of(cells_of(positions, speeds), signal)
    assert floor is not None
    assert 0.9 < floor / np.std(offsets) < 1.3


def test_what_repeats_leaves_a_small_floor():
    positions, speeds = motion(3)
    cells = cells_of(positions, speeds)
    assert all(numbers.min() >= 0 and numbers.max() < cell_count() for numbers in cells)
    floor = floor_of(cells, [np.sign(v) for v in speeds])
    assert floor is not None
    assert floor < 0.2


def test_positions_that_are_passed_once_tell_no_floor():
    t = np.linspace(0.0, 1.0, 500)
    assert floor_of(cells_of([t], [np.ones_like(t)]), [t]) is None


def test_a_fine_ripple_repeats():
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 60.0, 0.001)
    phases = rng.uniform(0.0, 2.0 * np.pi, (3, 2))
    positions = [0.6 * np.sin(0.7 * t + a) + 0.4 * np.sin(1.9 * t + b) for a, b in phases]
    speeds = [np.gradient(q, t) for q in positions]
    everywhere = [np.ones(t.size, dtype=bool)] * len(positions)
    # Seventy waves over the travel: a coarse cell holds nearly three, of which a pass sees what it happens to.
    signal = [np.sin(220.0 * q) + 0.1 * rng.standard_normal(t.size) for q in positions]
    coarse = floor_of(cells_of(positions, speeds), signal)
    lowest = lowest_floor(positions, speeds, signal, everywhere)
    assert coarse is not None
    assert lowest is not None
    assert lowest < 0.6 * coarse


def test_readings_that_tremble_over_edges_repeat_no_pass():
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 10.0, 0.001)
    # Once along the travel in each of two runs, whose signals differ by 2.
    positions = [0.1 * t + 5e-4 * rng.standard_normal(t.size) for _ in range(2)]
    speeds = [np.ones_like(t)] * 2
    floor = lowest_floor(positions, speeds, [np.ones_like(t), -np.ones_like(t)], [np.ones(t.size, dtype=bool)] * 2)
    assert floor == pytest.approx(np.sqrt(2.0), rel=0.3)
