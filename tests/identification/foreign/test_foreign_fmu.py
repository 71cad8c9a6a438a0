"""Foreign FMUs: what crashes, hangs or prints without end is one line, and the next simulation runs."""

from __future__ import annotations

import os
import time
import zipfile

import fmpy
import numpy as np
import pytest

from haptid.identification.foreign.process import ForeignFmu
from haptid.support.errors import InputError, NumericalError
from tests.fmu_build.fmu_cases import fmu
from tests.identification.foreign_cases import content, write
from tests.real_data import DATA

T = np.array([0.0, 0.5, 1.5, 1.75])


def simulated(fmu: ForeignFmu):
    inputs = {"force": np.array([1.0, 2.0, 4.0, 0.0])}
    return fmu.simulate(T, start={"position": 3.0}, inputs=inputs, outputs=["position", "force"])


@pytest.mark.parametrize("step", ["integrates", "prints"])
def test_rows_are_stepped_with_inputs_held_and_prints_go_nowhere(step, tmp_path, capfd):
    with ForeignFmu(write(tmp_path / "small.fmu", content(step))) as fmu:
        for _ in range(2):
            assert simulated(fmu).tolist() == [[3.0, 1.0], [3.5, 2.0], [5.5, 4.0], [6.5, 0.0]]
    assert capfd.readouterr() == ("", "")


def test_linear_inputs_are_set_as_their_mean_between_the_rows(tmp_path):
    inputs = {"force": np.array([1.0, 2.0, 4.0, 0.0])}
    with ForeignFmu(write(tmp_path / "small.fmu", content())) as fmu:
        y = fmu.simulate(T, start={"position": 3.0}, inputs=inputs, outputs=["position", "force"], linear=True)
    assert y.tolist() == [[3.0, 1.0], [3.75, 2.0], [6.75, 4.0], [7.25, 0.0]]


@pytest.mark.parametrize(
    ("step", "told"),
    [
        ("crashes", "its own code ended the process (signal SIG"),
        ("aborts", "its own code ended the process (signal SIGABRT)"),
        ("exits", "its own code ended the process (exit code 0)"),
        ("reports an error", "fmi2DoStep failed with status 3"),
        ("divides by zero", "its output position is nan at t = 1.5 s (row 3)"),
        ("overflows", "its output position is inf at t = 1.5 s (row 3)"),
    ],
)
def test_what_ends_the_fmu_is_one_line(step, told, tmp_path):
    with ForeignFmu(write(tmp_path / "small.fmu", content(step))) as fmu:
        for _ in range(2):  # the second is asked of a new child
            with pytest.raises(NumericalError) as caught:
                simulated(fmu)
            line = str(caught.value)
            assert line.startswith("small.fmu: ")
            assert told in line
            assert "\n" not in line
            assert len(line) <= 300


def test_a_process_that_wears_out_is_replaced(tmp_path):
    """OpenModelica's FMUs end a process at their 1,023rd instance; this one at its fourth."""
    with ForeignFmu(write(tmp_path / "small.fmu", content("wears out"))) as fmu:
        assert len({simulated(fmu).tobytes() for _ in range(8)}) == 1


def test_a_hang_is_ended_in_time_and_nothing_is_left(tmp_path):
    with ForeignFmu(write(tmp_path / "small.fmu", content("hangs")), limit_s=0.5) as fmu:
        fmu._start()  # what its process takes to begin does not count
        began = time.monotonic()
        with pytest.raises(NumericalError, match=r"small\.fmu: no answer within 0\.5 s"):
            simulated(fmu)
        assert time.monotonic() - began < 5.0
        child, folder = fmu._child.pid, fmu._folder
        with pytest.raises(ProcessLookupError):
            os.kill(child, 0)
    assert not folder.exists()


def test_a_variable_that_is_not_there_is_named_with_its_neighbour(tmp_path):
    with (
        ForeignFmu(write(tmp_path / "small.fmu", content())) as fmu,
        pytest.raises(InputError, match="got 'positon'; is 'position' meant"),
    ):
        fmu.simulate(T, start={}, inputs={}, outputs=["positon"])


@pytest.mark.real("foreign_fmus")
@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_a_reference_fmu_gives_its_exponential(version):
    t = np.linspace(0.0, 2.0, 21)
    with ForeignFmu(DATA / "foreign_fmus" / version / "Dahlquist.fmu") as fmu:
        (x,) = fmu.simulate(t, start={"k": 0.5}, inputs={}, outputs=["x"]).T
    steps = np.round(t / 0.1)  # the FMU steps by forward Euler, 0.1 s each
    np.testing.assert_allclose(x, (1 - 0.5 * 0.1) ** steps, rtol=1e-12)


@pytest.mark.parametrize(("kind", "told"), [("native", "guid: expected {"), ("native3", "the instantiation token {")])
def test_an_fmu_that_refuses_says_why_in_its_own_words(kind, told, tmp_path):
    own, other = fmu("joint4", kind).path, tmp_path / "other.fmu"
    identity = fmpy.read_model_description(str(own)).guid.encode()
    with zipfile.ZipFile(own) as files, zipfile.ZipFile(other, "w") as changed:
        for name in files.namelist():
            data = files.read(name)
            is_description = name == "modelDescription.xml"
            changed.writestr(name, data.replace(identity, b"{of another}") if is_description else data)
    with ForeignFmu(other) as foreign, pytest.raises(NumericalError) as caught:
        foreign.simulate(T, start={}, inputs={}, outputs=["joint4.reading"])
    assert told in str(caught.value)
