"""Code that pages show: command lines are understood, blocks compile and import, and what is quick is run as shown."""

from __future__ import annotations

import ast
import importlib
import re
import tomllib
from pathlib import Path
from unittest.mock import create_autospec

import click
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import haptid
from docs.parts.shown_code import blocks_of, check_command, commands_of
from haptid import Campaign, Identified, Missing, Posteriors
from haptid.command_line import main
from haptid.discrepancy.job.job import catalogue_without
from haptid.measurement.format.foreign_campaign import read_foreign_campaign
from haptid.support.installing.environment import ROOT
from tests.identification.plain_joint import plain_run

DOCS = ROOT / "docs"
HOW_TO = DOCS / "how-to"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
# Pages of results say by which command of their day they were made.
WITH_COMMANDS = [page for page in PAGES if "results" not in page.parts and commands_of(page)]
WITH_PYTHON = [page for page in PAGES if blocks_of(page, "python")]
WITH_TOML = [page for page in PAGES if blocks_of(page, "toml")]
RUN_IN = {
    "README": "tests/docs/test_shown_code.py",
    "docs/how-to/accuracy_of_an_fmu": "tests/identification/sequence/test_written_draws.py",
    "docs/how-to/find_missing_physics": "tests/docs/test_shown_code.py",
    "docs/how-to/foreign_fmu": "tests/identification/calibration/test_calibration.py",
    "docs/how-to/rigid_body_simulators": "tests/fmu_build/multibody/test_in_simulators.py",
    "docs/tutorial/from_tables_to_fmu": "tests/docs/test_tutorial.py",
    "docs/tutorial/through_python": "tests/api/test_page.py",
}
"""Which test runs the Python of a page; that of README with stand-ins for campaign and results."""
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?")


def named(page: Path) -> str:
    return str(page.relative_to(ROOT).with_suffix(""))


def test_all_kinds_of_code_are_found():
    assert len(WITH_COMMANDS) > 20
    assert {"how-to/commands.md", "how-to/your_own_data.md"} <= {str(p.relative_to(DOCS)) for p in WITH_COMMANDS[1:]}
    assert ["haptid", "missing", "my_campaign", "--out", "results"] in commands_of(ROOT / "README.md")


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=named)
def test_commands_of_a_page_are_understood(page: Path):
    for words in commands_of(page):
        check_command(words)


@pytest.mark.parametrize(
    "line",
    [
        "haptid idntify my_campaign",
        "haptid identify my_campaign --outt results",
        "haptid identify my_campaign other_campaign",
        "haptid identify my_campaign --starts",
        "haptid identify my_campaign --starts many",
        "haptid missing my_campaign --stage why",
        "python -m identification.run --scheduled",
    ],
)
def test_a_command_that_is_not_understood_is_found(line: str):
    with pytest.raises(click.UsageError):
        check_command(line.split())


def test_a_module_that_is_not_there_is_found():
    with pytest.raises(LookupError):
        check_command(["python", "-m", "identification.runs"])


@pytest.mark.parametrize("page", WITH_PYTHON, ids=named)
def test_python_of_a_page_compiles_and_imports(page: Path):
    for block in blocks_of(page, "python"):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.Import):
                for one in node.names:
                    importlib.import_module(one.name)
            if isinstance(node, ast.ImportFrom):
                module = importlib.import_module(node.module or "")
                assert all(hasattr(module, one.name) for one in node.names), ast.unparse(node)


def test_the_python_of_every_page_is_run_somewhere():
    assert {named(page) for page in WITH_PYTHON} == set(RUN_IN)
    writers = {"docs/tutorial/from_tables_to_fmu": "tutorial_page", "docs/tutorial/through_python": "python_api"}
    for page, test in RUN_IN.items():
        text = (ROOT / test).read_text(encoding="utf-8")
        assert Path(page).name in text or writers[page] in text, page


@pytest.mark.parametrize("page", WITH_TOML, ids=named)
def test_toml_of_a_page_is_toml(page: Path):
    for block in blocks_of(page, "toml"):
        assert tomllib.loads(block)


def test_calls_of_the_readme_have_the_names_and_arguments_of_the_api(monkeypatch: pytest.MonkeyPatch):
    (block,) = blocks_of(ROOT / "README.md", "python")
    campaign, identified = create_autospec(Campaign, instance=True), create_autospec(Identified, instance=True)
    campaign.identify.return_value = identified
    identified.posterior.return_value = create_autospec(Posteriors, instance=True)
    identified.find_missing.return_value = create_autospec(Missing, instance=True)
    stand_in = create_autospec(Campaign)
    stand_in.from_frames.return_value = campaign
    monkeypatch.setattr(haptid, "Campaign", stand_in, raising=False)
    exec(block, {name: pd.DataFrame() for name in ("slow", "fast", "unseen")})
    identified.find_missing.return_value.export_fmu.assert_called_once_with("with_effects.fmu")
    identified.plot_residuals.assert_called_once_with()


def shown(page: str, languages: tuple[str, ...], start: str) -> str:
    """Block of a page that begins with these words."""
    (block,) = [one for one in blocks_of(HOW_TO / page, *languages) if one.startswith(start)]
    return block


def run(line: str) -> str:
    """Run a shown command in this process and return what it prints."""
    (words,) = [words for page in PAGES for words in commands_of(page) if words == line.replace("'", "").split()][:1]
    done = CliRunner().invoke(main, words[1:])
    assert done.exit_code == 0, done.output
    return done.output


def write_logged_tables(folder: Path) -> None:
    folder.mkdir()
    for seed, name in enumerate(("ddp", "val_direct_collocation")):
        one = plain_run(seed, seconds=4.0)
        columns = {"time_ms": 1e3 * one.t, "torque (Nmm)": 1e3 * one.u[:, 0], "Angle (deg)": np.degrees(one.y[:, 0])}
        pd.DataFrame(columns).to_csv(folder / f"{name}.csv", index=False)


@pytest.mark.long
def test_tables_are_brought_in_checked_and_identified_as_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    write_logged_tables(tmp_path / "my_tables")
    printed = run("haptid init my_tables --out my_campaign --measured --validate 'val_*.csv'")
    promised = shown("your_own_data.md", ("",), "understood:")
    said, expected = (NUMBER.sub("#", text).split() for text in (printed, promised))
    assert said[: len(expected)] == expected
    assert said[len(expected)] == "next:"
    run("haptid check my_campaign")
    run("haptid identify my_campaign --out out")
    assert {"identification.json", "report.html", "joint0.fmu"} <= {path.name for path in (tmp_path / "out").iterdir()}


def test_the_campaign_of_a_page_is_accepted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "my_campaign"
    folder.mkdir()
    (folder / "campaign.toml").write_text(shown("your_own_data.md", ("toml",), "[campaign]"), encoding="utf-8")
    one = plain_run(1, seconds=4.0)
    table = {"time_s": one.t, "torque_2_Nm": one.u[:, 0], "position_2_rad": one.y[:, 0]}
    pd.DataFrame(table).to_csv(folder / "run1.csv", index=False)
    run("haptid check my_campaign")
    campaign = Campaign.read(folder)
    assert campaign.values.friction == {2: "dahl"}
    assert campaign.values.parameter_overrides[2]["Kp"] == {"fixed": 1.0}


def test_the_campaign_about_an_fmu_of_a_page_is_accepted(tmp_path: Path):
    (tmp_path / "campaign.toml").write_text(shown("foreign_fmu.md", ("toml",), "[campaign]"), encoding="utf-8")
    (tmp_path / "oscillator.fmu").write_bytes(b"")  # it is opened later
    t = np.arange(0.0, 4.0, 0.01)
    pd.DataFrame({"time_s": t, "force_N": np.cos(t), "x": np.sin(t)}).to_csv(tmp_path / "a.csv", index=False)
    campaign = read_foreign_campaign(tmp_path)
    assert set(campaign.parameters) == {"mu", "mass", "damping"}


def test_the_effect_of_a_page_enters_the_catalogue(tmp_path: Path):
    (tmp_path / "seal_drag.py").write_text(
        shown("find_missing_physics.md", ("python",), '"""Friction'), encoding="utf-8"
    )
    effects = catalogue_without((), tmp_path)
    assert effects["seal_drag"].parameters[0].id == "seal"
