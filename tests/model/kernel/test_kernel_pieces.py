"""Long simulations run in pieces: the same bits, and Ctrl-C or SIGTERM is heard between them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptid.model.kernel import compiled
from haptid.model.kernel.pieces import pieces
from haptid.model.thresholds import THRESHOLDS
from tests.model.kernel_cases import KERNEL, TENDON, torque, vector

ROOT = Path(__file__).parents[3]
T = np.arange(0.0, 4.0, 0.005)
X0 = [0.1, 0.0, 0.0]


@given(st.lists(st.floats(1e-4, 0.5), min_size=1, max_size=60), st.floats(1e-3, 0.1), st.integers(1, 200))
def test_pieces_meet_and_are_short(gaps: list[float], step: float, most: int):
    t = np.concatenate(([0.0], np.cumsum(gaps)))
    parts = pieces(t, step, most)
    assert parts[0].start == 0
    assert parts[-1].stop == t.size
    assert all(a.stop == b.start + 1 for a, b in pairwise(parts))
    for part in parts:
        inner = np.diff(t[part])
        assert inner.size
        assert inner.size == 1 or np.maximum(np.ceil(inner / step), 1).sum() <= most + inner.size


def short(t: np.ndarray, step: float) -> list[slice]:
    return pieces(t, step, most=70)


def test_pieces_have_the_bits_of_the_whole(monkeypatch: pytest.MonkeyPatch):
    u, p = torque(T, 5e-3), vector(TENDON)
    many = np.array([p, 1.1 * p, 0.9 * p, p, p, 1.2 * p])
    starts = np.tile(X0, (len(many), 1))

    def run() -> list[np.ndarray]:
        together = [KERNEL.simulate_many(T, u, many, starts, threads=n) for n in (1, 2)]
        through = KERNEL.simulate_through(T, u, p, X0, linear=True)
        return [*through, *KERNEL.simulate_tangent(T, u, p, X0, linear=True), *together]

    whole = run()
    monkeypatch.setattr(compiled, "pieces", short)
    monkeypatch.setattr(compiled, "THRESHOLDS", replace(THRESHOLDS, most_inner_steps_of_call=70))
    assert len(short(T, KERNEL.kernel.step)) > 10
    for one, other in zip(whole, run(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_state_that_blows_up_in_an_early_piece_leaves_nan_after_it(monkeypatch: pytest.MonkeyPatch):
    bad = vector(TENDON | {"Ks": -1e3})
    whole = KERNEL.simulate(T, torque(T, 5e-3), bad, X0)
    monkeypatch.setattr(compiled, "pieces", short)
    np.testing.assert_array_equal(KERNEL.simulate(T, torque(T, 5e-3), bad, X0), whole)
    assert np.isnan(whole[-1])


def heard() -> None:
    """Children of a background job ignore Ctrl-C; this one is to hear it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


LONG = """
import numpy as np
from haptid.support.command import exit_codes
from tests.model.kernel_cases import KERNEL, TENDON, torque, vector

@exit_codes
def main():
    t = np.arange(0.0, 5_000.0, 0.005)
    print("begun", flush=True)
    KERNEL.{call}

main()
"""
CALLS = {
    "simulate": "simulate(t, torque(t, 5e-3), vector(TENDON), [0.1, 0.0, 0.0], step=1e-5)",
    "tangent": "simulate_tangent(t, torque(t, 5e-3), vector(TENDON), [0.1, 0.0, 0.0], step=1e-5)",
}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("call", CALLS)
def test_signals_are_heard_within_two_seconds(call: str, number: signal.Signals):
    code = LONG.replace("{call}", CALLS[call])
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=heard,  # noqa: PLW1509 (no thread of this process is in the child)
    )  # fmt: skip
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        time.sleep(1.0)
        process.send_signal(number)
        begun = time.monotonic()
        _, errors = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 128 + number
    assert errors.splitlines() == ["interrupted: nothing was finished yet"]
    assert time.monotonic() - begun < 10.0  # a promise of 2 s, on a machine that does other work besides
