"""Every function of FMI 3.0 in every mode with every kind of argument answers as the standard says."""

from __future__ import annotations

import re

import numpy as np
import pytest

from haptid.support.installing.environment import ROOT
from tests.fmu_build.conformance.harness3 import CALLS3, Harness3
from tests.fmu_build.conformance.table import DISCARD, ERROR, OK
from tests.fmu_build.conformance.table3 import INTERFACES, MODES, TABLE3
from tests.fmu_build.fmu_cases import fmu

CELLS = {"co-simulation": 748, "model exchange": 935}
"""Cells of each interface: 1683 together."""
MADE_AND_FREED = {
    "InstantiateCoSimulation",
    "InstantiateModelExchange",
    "InstantiateScheduledExecution",
    "FreeInstance",
}


def test_the_table_holds_every_function():
    header = (ROOT / "fmu_build" / "native" / "c" / "fmi3.h").read_text(encoding="utf-8")
    functions = set(re.findall(r"#define fmi3([A-Z]\w+) FMI3_FULL_NAME", header))
    assert set(TABLE3) == functions - MADE_AND_FREED
    assert {name: set(row.answers) for name, row in TABLE3.items()} == {k: set(v) for k, v in CALLS3.items()}


@pytest.mark.parametrize("interface", CELLS)
def test_every_cell_answers_as_the_standard_says(interface: str):
    h, cells = Harness3(fmu("joint4", "native3"), interface), {}
    for mode in INTERFACES[interface]:
        for function, row in TABLE3.items():
            for argument in row.answers:
                h.bring(mode)
                h.messages.clear()
                came = CALLS3[function][argument](h)
                cells[MODES[mode], function, argument] = (came, row.expected(interface, mode, argument))
                assert came == OK or h.messages, (MODES[mode], function, argument)
                h.tidy()
    wrong = {cell: statuses for cell, statuses in cells.items() if statuses[0] != statuses[1]}
    print(f"FMI 3.0, {interface}: {len(cells)} cells, {len(wrong)} differ")
    assert wrong == {}
    assert len(cells) == CELLS[interface]
    h.free()


@pytest.mark.alone
@pytest.mark.parametrize("interface", CELLS)
def test_after_any_sequence_of_calls_a_reset_starts_over(interface: str):
    calls = [call for kinds in CALLS3.values() for call in kinds.values()]
    rng, fresh = np.random.default_rng(0), Harness3(fmu("joint4", "native3"), interface)
    h = Harness3(fmu("joint4", "native3"), interface)
    for _ in range(50):
        for index in rng.integers(0, len(calls), 200):
            assert calls[index](h) in {OK, DISCARD, ERROR}
        h.tidy()
        for one in (fresh, h):
            one.bring(INTERFACES[interface][-2])  # the mode in which it runs
        assert h.bytes_of(h.saved()) == fresh.bytes_of(fresh.saved())
        for one in (fresh, h):
            one.tidy()
