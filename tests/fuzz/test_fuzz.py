"""Every reader reads or refuses, in one line: 200 to 2,000 inputs each, and those that once failed."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tests.fuzz.harness import Fault, Tally, Target, call, inputs_of
from tests.fuzz.targets import TARGETS

SEEDS = Path(__file__).parent / "seeds"
STORED = sorted(path for path in SEEDS.rglob("*") if path.is_file())


@pytest.mark.parametrize("name", TARGETS)
def test_examples_are_valid(name, tmp_path):
    for number, example in enumerate(TARGETS[name].examples):
        folder = tmp_path / str(number)
        folder.mkdir()
        TARGETS[name].read(example, folder)


@pytest.mark.parametrize("name", TARGETS)
def test_readers_read_or_refuse_in_one_line(name):
    tally = Tally()

    @settings(
        max_examples=TARGETS[name].tested,
        derandomize=True,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )
    @given(st.data())
    def read_or_refuse(data):
        call(TARGETS[name], data.draw(inputs_of(TARGETS[name])), tally)

    read_or_refuse()
    assert tally.inputs >= TARGETS[name].tested // 2  # an exhausted strategy would end early


@pytest.mark.parametrize("path", STORED, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_inputs_that_once_failed(path):
    if path.parent.name not in TARGETS:
        pytest.skip("the package of this reader is not installed")
    call(TARGETS[path.parent.name], path.read_bytes())


def _target(read) -> Target:
    return Target(name="made_up", examples=(b"a",), read=read)


def test_other_exceptions_are_faults():
    def read(content, _folder):
        int(content)

    with pytest.raises(Fault, match="ValueError"):
        call(_target(read), b"a")


def test_endless_calls_are_faults():
    def read(_content, _folder):
        while True:
            pass

    with pytest.raises(Fault, match=r"more than 5\.0 s"):
        call(_target(read), b"a")


def test_hungry_calls_are_faults():
    def read(_content, _folder):
        return b"\1" * (700 << 20)

    tally = Tally()
    with pytest.raises(Fault, match="memory grew"):
        call(_target(read), b"a", tally)
