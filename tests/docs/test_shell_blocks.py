"""Blocks of command lines on the how-to pages are run as they stand, in a temporary folder, where that takes a minute.

Which test runs which block stands in `RUN_IN`; which blocks no test runs, and why, in `NOT_RUN`.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pandas as pd
import pytest

from docs.parts.shown_code import SHELLS, blocks_of
from haptid.support.installing.environment import ROOT
from tests.docs.test_shown_code import HOW_TO, shown, write_logged_tables
from tests.identification.calibration_cases import write_decay
from tests.identification.plain_joint import plain_run

SHOWN_CODE = "tests/docs/test_shown_code.py"
RUN_IN = {
    (
        "commands",
        "haptid identify my_campaign --out results --json | jq",
    ): "test_results_of_one_joint_are_printed_and_exported_and_simulated",
    ("commands", "haptid init my_tables --out my_campaign --yes"): "test_tables_are_brought_in_without_a_question",
    ("commands", "haptid fleet all_campaigns"): "test_devices_are_compared",
    ("commands", "echo 'eval"): "test_a_new_shell_completes",
    ("commands", "echo 'autoload"): "test_a_new_shell_completes",
    ("commands", "mkdir -p ~/.config/fish"): "test_a_new_shell_completes",
    ("find_missing_physics", "python -m discrepancy.run my_campaign --joint 3 --out"): "test_a_joint_is_searched",
    ("find_missing_physics", "python -m discrepancy.run my_campaign --joint 3 --effects"): "test_a_joint_is_searched",
    ("foreign_fmu", "python -m measurement.check my_campaign"): "test_an_fmu_of_others_is_calibrated",
    ("foreign_fmu", "python -m identification.run my_campaign"): "test_an_fmu_of_others_is_calibrated",
    ("foreign_fmu", "python -m uq.run results"): "test_an_fmu_of_others_is_calibrated",
    (
        "other_simulators",
        "python -m fmu_build.export",
    ): "test_results_of_one_joint_are_printed_and_exported_and_simulated",
    ("other_simulators", "fmpy validate"): "test_results_of_one_joint_are_printed_and_exported_and_simulated",
    ("plan_the_tests", "python -m model.plan my_device.toml"): "test_tests_are_planned",
    ("plan_the_tests", "python -m identification.run my_campaign"): "test_a_joint_is_searched",
    ("rigid_body_simulators", "haptid export"): "test_bodies_are_exported",
    ("your_own_data", "haptid init my_tables"): SHOWN_CODE,
    ("your_own_data", "haptid check my_campaign"): SHOWN_CODE,
    ("your_own_data", "haptid identify my_campaign"): SHOWN_CODE,
}
"""Test that runs the block of a page which begins with these words."""
MINUTES, OTHERS = "takes minutes", "needs what others install"
NOT_RUN = {
    ("cluster", "dask scheduler"): "needs several machines; tests/identification/job has a scheduler on one",
    ("find_missing_physics", "python -m discrepancy.run my_campaign --free 0,1 --out"): MINUTES,
    ("find_missing_physics", "python -m discrepancy.run my_campaign --free 0,1,2"): MINUTES,
    ("find_missing_physics", "python -m fmu_build.export"): MINUTES,
    ("find_missing_physics", "make blind"): MINUTES,
    ("other_simulators", "pip install ecospy"): OTHERS,
    ("other_simulators", "pip install OMSimulator"): OTHERS,
    ("other_simulators", "conda install"): OTHERS,
    ("other_simulators", "fmuCheck.linux64"): OTHERS,
    ("other_simulators", "export LD_PRELOAD"): "states a variable of the reader's shell",
    ("plan_the_tests", "python -m identification.run --out planned_result"): MINUTES,
    ("plan_the_tests", "python -m model.plan --tests 10"): MINUTES,
    ("your_own_data", "understood:"): "is what a command prints",
}
"""Why no test runs the block of a page which begins with these words."""
LONGEST_S = 300.0
"""Time after which a block is given up, on a machine that does much else [s]."""
TESTS = Path(__file__)


def test_every_block_of_command_lines_is_run_or_says_why_not():
    told = {**RUN_IN, **NOT_RUN}
    assert len(told) == len(RUN_IN) + len(NOT_RUN)
    found = []
    for page in sorted(HOW_TO.glob("*.md")):
        for block in blocks_of(page, *SHELLS):
            keys = [key for key in told if key[0] == page.stem and block.startswith(key[1])]
            assert len(keys) == 1, f"{page.name}: {block}"
            found += keys
    assert sorted(found) == sorted(told)


@pytest.mark.parametrize("key", RUN_IN, ids="-".join)
def test_the_named_test_runs_the_block(key: tuple[str, str]):
    place, (page, start) = RUN_IN[key], key
    text = (ROOT / place if place.endswith(".py") else TESTS).read_text(encoding="utf-8")
    if place.endswith(".py"):
        assert start in text
    else:
        body = text.partition(f"def {place}(")[2].partition("\n\n\n")[0]
        assert f'"{page}", "{start}"' in body


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Variables of a shell that has ``haptid`` and ``python`` as this interpreter has them."""
    tools = tmp_path_factory.mktemp("tools")
    for name, words in (("haptid", "-m haptid"), ("python", "")):
        (tools / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {words} "$@"\n', encoding="utf-8")
        (tools / name).chmod(0o755)
    path = os.pathsep.join([str(tools), str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}


@pytest.fixture(scope="module")
def shell(environment: dict[str, str]):
    """Run a block of a page in a folder."""

    def run(folder: Path, page: str, start: str, **variables: str) -> str:
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", shown(f"{page}.md", ("", "bash"), start)],
            cwd=folder, env=environment | variables, capture_output=True, text=True, timeout=LONGEST_S, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.mark.parametrize("name", ["bash", "zsh", "fish"])
def test_a_new_shell_completes(tmp_path: Path, shell, environment: dict[str, str], name: str):
    """Zsh did not know compdef, and the folder of Fish was not there."""
    if shutil.which(name) is None:
        pytest.skip("the shell is not installed")
    block, words, told = {
        "bash": (("commands", "echo 'eval"), ["-i", "-c", "complete -p haptid"], "-F _haptid_completion haptid"),
        "zsh": (("commands", "echo 'autoload"), ["-i", "-c", "echo ${_comps[haptid]}"], "_haptid_completion"),
        "fish": (("commands", "mkdir -p ~/.config/fish"), ["-c", "complete -C'haptid plan free'"], "freedom6s"),
    }[name]
    home = {"HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path / ".config"), "ZDOTDIR": str(tmp_path)}
    shell(tmp_path, *block, **home)
    done = subprocess.run(
        [name, *words], cwd=tmp_path, env=environment | home, stdin=subprocess.DEVNULL, capture_output=True, text=True,
        timeout=LONGEST_S, check=False,
    )  # fmt: skip
    assert told in done.stdout
    assert "not found" not in done.stderr


def write_campaign(folder: Path, joint: int, seeds: range = range(3)) -> None:
    """Write a campaign of one joint with Coulomb friction, of which the last run is kept from the fit."""
    folder.mkdir(parents=True)
    lines = ["[campaign]", 'title = "A joint"', 'device = "single_joint"', "measured = false", 'hold = "linear"']
    for seed in seeds:
        one = plain_run(seed, seconds=4.0)
        columns = {"time_s": one.t, f"torque_{joint}_Nm": one.u[:, 0], f"position_{joint}_rad": one.y[:, 0]}
        pd.DataFrame(columns).to_csv(folder / f"run{seed}.csv", index=False)
        use = "validate" if seed == seeds[-1] else "fit"
        lines += ["[[runs]]", f'file = "run{seed}.csv"', f"free_joints = [{joint}]", f'use = "{use}"']
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.long
@pytest.mark.skipif(shutil.which("jq") is None, reason="the page pipes into jq")
def test_results_of_one_joint_are_printed_and_exported_and_simulated(tmp_path: Path, shell):
    write_campaign(tmp_path / "my_campaign", joint=4)
    printed = shell(tmp_path, "commands", "haptid identify my_campaign --out results --json | jq")
    inertia, _, verdict = printed.rpartition("}\n")
    assert json.loads(inertia + "}")["value"] == pytest.approx(0.05, rel=0.05)
    assert verdict.strip() in ("nothing_missing", "named", "partly_named", "ambiguous", "unlisted")
    results = tmp_path / "results"
    shutil.copy(results / "joint4.ssv", results / "parameters.ssv")
    shell(results, "other_simulators", "python -m fmu_build.export")
    assert zipfile.is_zipfile(results / "freedom6s.fmu")
    fmus = tmp_path / "artifacts" / "fmu"
    fmus.mkdir(parents=True)
    shutil.copy(results / "joint4.fmu", fmus)
    with zipfile.ZipFile(results / "joint4.fmu") as archive:
        (tmp_path / "joint4_in.csv").write_bytes(archive.read("documentation/joint4_in.csv"))
    pytest.importorskip("fmpy", reason="the page asks for it")
    shell(tmp_path, "other_simulators", "fmpy validate")
    assert pd.read_csv(tmp_path / "out.csv").iloc[-1, 0] == pytest.approx(2.0)


def test_tables_are_brought_in_without_a_question(tmp_path: Path, shell):
    write_logged_tables(tmp_path / "my_tables")
    shell(tmp_path, "commands", "haptid init my_tables --out my_campaign --yes")
    assert (tmp_path / "my_campaign" / "campaign.toml").is_file()


@pytest.mark.long
def test_devices_are_compared(tmp_path: Path, shell):
    for name, seeds in (("first", range(2)), ("second", range(2, 4))):
        write_campaign(tmp_path / "all_campaigns" / name, joint=0, seeds=seeds)
    shell(tmp_path, "commands", "haptid fleet all_campaigns")
    assert list((tmp_path / "fleet").glob("*.html"))


@pytest.mark.long
def test_a_joint_is_searched(tmp_path: Path, shell):
    write_campaign(tmp_path / "my_campaign", joint=3)
    shell(tmp_path, "plan_the_tests", "python -m identification.run my_campaign")
    shell(tmp_path, "find_missing_physics", "python -m discrepancy.run my_campaign --joint 3 --out")
    assert (tmp_path / "out" / "discrepancy" / "joint3.html").is_file()
    (tmp_path / "my_effects").mkdir()
    effect = shown("find_missing_physics.md", ("python",), '"""Friction')
    (tmp_path / "my_effects" / "seal_drag.py").write_text(effect, encoding="utf-8")
    shell(tmp_path, "find_missing_physics", "python -m discrepancy.run my_campaign --joint 3 --effects")


@pytest.mark.long
@pytest.mark.real("foreign_fmus")
def test_an_fmu_of_others_is_calibrated(tmp_path: Path, shell):
    made = write_decay(tmp_path / "made")
    shutil.copytree(made, tmp_path / "my_campaign")
    shutil.copy(made / "decay.fmu", tmp_path / "any.fmu")
    shell(tmp_path, "foreign_fmu", "python -m measurement.check my_campaign")
    shell(tmp_path, "foreign_fmu", "python -m identification.run my_campaign")
    assert (tmp_path / "results" / "identified.fmu").is_file()
    shell(tmp_path, "foreign_fmu", "python -m uq.run results")
    assert (tmp_path / "results" / "posterior.json").is_file()


@pytest.mark.long
def test_tests_are_planned(tmp_path: Path, shell):
    shutil.copy(ROOT / "docs" / "examples" / "two_joints.toml", tmp_path / "my_device.toml")
    shell(tmp_path, "plan_the_tests", "python -m model.plan my_device.toml")
    assert (tmp_path / "plan" / "locking_plan.html").is_file()


@pytest.mark.long
def test_bodies_are_exported(tmp_path: Path, shell):
    words = ["-m", "haptid", "identify", "--joints", "4", "--out", str(tmp_path / "results")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, *words], cwd=tmp_path, env=environment, capture_output=True, check=True)
    shell(tmp_path, "rigid_body_simulators", "haptid export")
    assert {"freedom6s.xml", "freedom6s.urdf"} <= {path.name for path in tmp_path.iterdir()}
