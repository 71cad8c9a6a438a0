"""The floor: what differs between passes of one position and speed, and nothing that comes back."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.measurement.signals.repeats import cell_count, cells_of, floor_of

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
