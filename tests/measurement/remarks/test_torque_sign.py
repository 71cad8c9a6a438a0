"""A torque of the wrong sign is told from the joint's runs together, where no run shows it alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.measurement.commands import init
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.remarks.suspicions import suspicions
from haptid.measurement.remarks.torque_sign import wrong_signs
from haptid.measurement.signals.noise import with_noise
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from tests.measurement.remarks.test_suspicions import a_run


def fast_runs(omegas: Sequence[float] = (9.0, 14.0, 20.0), viscous: float = 1e-3) -> list[Run]:
    """A mass of 0.05 kg m² on a spring with hardly any friction, the faster the smaller its travel."""
    t, rng = np.arange(0.0, 8.0, 2e-3), np.random.default_rng(0)
    runs = []
    for omega in omegas:
        y = 0.4 * np.sin(omega * t) * 9.0 / omega
        v, a = np.gradient(y, t), -(omega**2) * y
        u = 0.05 * a + viscous * v + 0.2 * y
        runs.append(a_run(t, u, y + 1e-4 * rng.standard_normal(t.size), file=f"w{omega:g}.csv"))
    return runs


def turned(runs: Sequence[Run], *which: int) -> list[Run]:
    return [run.but(u=-run.u) if k in which else run for k, run in enumerate(runs)]


def test_right_signs_are_not_remarked():
    assert not wrong_signs(fast_runs())


@pytest.mark.parametrize("which", [(0,), (1,), (2,), (0, 2)])
def test_the_runs_of_the_wrong_sign_are_named(which: tuple[int, ...]):
    runs = turned(fast_runs(), *which)
    found = wrong_signs(runs)
    assert sorted(found) == sorted(runs[k].file for k in which)
    assert all("only with the opposite sign" in sentence for sentence in found.values())


def test_where_all_signs_are_wrong_the_inertia_says_so():
    runs = fast_runs()
    found = wrong_signs(turned(runs, 0, 1, 2))
    assert sorted(found) == sorted(run.file for run in runs)
    assert all("negative inertia" in sentence for sentence in found.values())


def test_of_two_runs_the_inertia_tells_which():
    runs = turned(fast_runs((9.0, 14.0), viscous=0.3), 1)
    assert wrong_signs(runs) == {
        "w14.csv": "its torque fits those of w9.csv only with the opposite sign: is the torque's sign wrong? "
        "multiply it by -1 in this run's table, or exclude the run"
    }


def test_what_mends_a_wrong_sign_of_all_runs_does(tmp_path: Path):
    """The remark asked whether the sign was wrong, and did not say what to do."""
    tables = tmp_path / "tables"
    tables.mkdir()
    for run in fast_runs():
        table = np.column_stack([run.t, -1000.0 * run.u[:, 0], run.y[:, 0]])
        np.savetxt(tables / run.file, table, delimiter=",", header="t,M [Nmm],phi", comments="")
    maps = ["--map", "t=time_s", "--map", "phi=position_0_rad", "--yes", "--map"]

    def remarks_with(factor: str) -> list[str]:
        out = tmp_path / f"factor{factor}"
        arguments = [str(tables), "--out", str(out), *maps, f"M [Nmm]=torque_0_Nm*{factor}"]
        made = CliRunner().invoke(init, arguments)
        assert made.exit_code == 0, made.output
        return [one for one in made.output.splitlines() if "torque's sign" in one]

    remedy = "turn it by haptid init --map 'COLUMN=torque_0_Nm*-1' (in mN m, *-0.001), or the position likewise"
    assert all(said.endswith(remedy) for said in remarks_with("0.001"))
    assert not remarks_with("-0.001")


def test_excluded_runs_and_other_postures_are_not_compared():
    runs = fast_runs()
    one = turned(runs, 2)[2]
    assert not wrong_signs([*runs[:2], one.but(use="excluded")])
    assert set(wrong_signs([*runs[:2], one.but(posture=np.array([0.5]))])) <= {one.file}


@pytest.fixture(scope="module")
def paper() -> Campaign:
    return read_campaign(embedded_campaign("paper"))


@pytest.mark.parametrize("joint", [0, 4])
def test_a_fast_run_of_the_embedded_campaign_is_found_that_its_own_rows_do_not_tell(paper: Campaign, joint: int):
    runs = [run for run in paper.runs_of((joint,)) if run.use != "excluded"]
    fastest = max(runs, key=lambda run: float(np.std(np.gradient(run.y[:, 0], run.t)) / np.std(run.y[:, 0])))
    wrong = fastest.but(u=-fastest.u)
    assert list(wrong_signs([wrong if run is fastest else run for run in runs])) == [fastest.file]
    assert not wrong_signs(runs)


def test_a_run_alone_hardly_shows_it():
    run = turned(fast_runs(), 2)[2]
    assert not [remark for remark in suspicions(run, with_noise(run), 0) if "sign" in remark]
