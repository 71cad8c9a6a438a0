"""Every function of FMI 2.0 in every mode with every kind of argument answers as the standard says."""

from __future__ import annotations

import math
from ctypes import byref, c_double

import pytest

from haptid.fmu_build.building.packaging import Kind
from tests.fmu_build.conformance.harness import CALLS, STOP, Harness
from tests.fmu_build.conformance.table import DISCARD, ERROR, INTERFACES, MODES, OK, TABLE
from tests.fmu_build.fmu_cases import fmu

CELLS = {("native", "co-simulation"): 665, ("native", "model exchange"): 665, ("python", "co-simulation"): 540}
"""Cells of each packaging and interface: 1870 together. A Python FMU has no functions of model exchange."""
DERIVATIVES = {"fmi2GetDirectionalDerivative"}
"""Functions that a Python FMU does not provide (providesDirectionalDerivative is false)."""


def answers(h: Harness, kind: Kind) -> dict[tuple[str, str, str], tuple[int, int]]:
    """Status that came and status that was expected, by mode, function and kind of argument."""
    cells = {}
    for mode in INTERFACES[h.interface]:
        for function, row in TABLE.items():
            if not hasattr(h.library, function):
                assert (kind, row.only) == ("python", "model exchange"), function
                continue
            assert CALLS[function].keys() >= row.answers.keys()
            for argument in row.answers:
                h.bring(mode)
                h.messages.clear()
                came = CALLS[function][argument](h)
                expected = row.expected(h.interface, mode, argument)
                if kind == "python" and function in DERIVATIVES:
                    expected = ERROR
                cells[MODES[mode], function, argument] = (came, expected)
                assert came == OK or h.messages, (MODES[mode], function, argument)
                h.tidy()
    return cells


@pytest.mark.parametrize(("kind", "interface"), CELLS)
def test_every_cell_answers_as_the_standard_says(kind: Kind, interface: str):
    h = Harness(fmu("joint4", kind), interface)
    cells = answers(h, kind)
    wrong = {cell: statuses for cell, statuses in cells.items() if statuses[0] != statuses[1]}
    print(f"{kind}, {interface}: {len(cells)} cells, {len(wrong)} differ")
    assert wrong == {}
    assert len(cells) == CELLS[kind, interface]
    h.free()
    assert not h.blocks


@pytest.mark.parametrize("kind", ["native", "python"])
def test_a_refused_call_leaves_the_instance_as_it_was(kind: Kind):
    h = Harness(fmu("joint4", kind), "co-simulation")
    h.bring("S")
    assert h.step(0.0, 0.01) == OK
    before = h.bytes_of(h.saved())
    for t, dt in (
        (0.0, 0.01),
        (0.02, 0.01),
        (0.01, -0.01),
        (0.01, math.nan),
        (math.inf, 0.01),
        (0.01, STOP),
        (0.01, 1e300),
    ):
        assert h.step(t, dt) == ERROR
    for argument in ("output", "outside", "NaN", "good and bad", "state"):
        assert CALLS["fmi2SetReal"][argument](h) == ERROR
    assert h.bytes_of(h.saved()) == before
    assert h.step(0.01, 0.01) == OK


@pytest.mark.parametrize("kind", ["native", "python"])
def test_after_a_failed_step_the_last_good_state_can_be_read_and_restored(kind: Kind):
    h = Harness(fmu("joint4", kind), "co-simulation")
    h.bring("N")
    h.set("velocity", 1e300)
    h.set("torque", 1e-3)
    assert h.call("fmi2ExitInitializationMode") == OK
    kept = h.saved()
    assert h.step(0.0, 0.1) == DISCARD
    assert "left the finite numbers between t = 0 s and 1e-1 s" in h.messages[-1]
    assert (h.get("velocity"), h.get("position"), h.get("reading")) == (1e300, 0.0, 0.0)
    assert last_time(h) == 0.0
    assert h.step(0.0, 0.01) == ERROR
    assert "expected in mode step complete, got mode step failed" in h.messages[-1]
    assert h.call("fmi2SetFMUstate", kept) == OK
    assert h.get("torque") == 1e-3
    h.bring("S")
    assert h.step(0.0, 0.01) == OK
    assert last_time(h) == 0.01


def last_time(h: Harness) -> float:
    value = c_double()
    assert h.call("fmi2GetRealStatus", 2, byref(value)) == OK
    return value.value


@pytest.mark.parametrize("kind", ["native", "python"])
def test_messages_say_what_was_expected(kind: Kind):
    h = Harness(fmu("joint4", kind), "co-simulation")
    h.bring("S")
    for arguments, expected in (
        ((0.5, 0.01), "expected the time at which the instance is, 0 s, got 5e-1 s"),
        ((0.0, STOP + 1), "expected a time up to the stop time 1e1 s, got 1.1e1 s"),
        ((0.0, -1.0), "expected a finite time and a positive step, got 0 s and -1 s"),
    ):
        assert h.step(*arguments) == ERROR
        assert h.messages[-1] == f"fmi2DoStep: {expected}"
    h.bring("T")
    assert h.set("torque", 0.0) == ERROR
    assert h.messages[-1].endswith("got mode terminated")
