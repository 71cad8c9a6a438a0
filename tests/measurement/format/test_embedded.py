"""The embedded campaigns: which there are, how they are named, and what they share."""

from __future__ import annotations

import importlib
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner

from haptid.api.campaign import Campaign
from haptid.measurement.checks.motion import in_first_postures
from haptid.measurement.format.embedded import FOLDERS, choose_campaign, embedded_campaign, embedded_option, name_of
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.values.postures import locked_posture
from haptid.support.command import exit_codes
from haptid.support.errors import InputError


@click.command()
@click.argument("campaign", required=False)
@exit_codes
@embedded_option
def told(campaign: Path | str | None) -> None:
    """Print the campaign that a command gets."""
    click.echo(str(campaign))


def test_a_name_is_its_folder_and_the_planned_one_is_the_default() -> None:
    assert name_of(embedded_campaign()) == "planned"
    for name, folder in FOLDERS.items():
        assert embedded_campaign(name).name == folder
        assert name_of(embedded_campaign(name)) == name
    assert name_of(Path(__file__).parent) is None
    with pytest.raises(InputError, match=r"--campaign.*planned, paper.*got 'papr'; did you mean paper"):
        embedded_campaign("papr")


def test_the_option_gives_the_folder_of_an_embedded_campaign() -> None:
    run = CliRunner()
    assert run.invoke(told, []).output.strip() == "None"
    assert run.invoke(told, ["mine"]).output.strip() == "mine"
    for name in FOLDERS:
        assert run.invoke(told, ["--campaign", name]).output.strip() == str(embedded_campaign(name))


def test_a_campaign_and_the_name_of_another_are_refused() -> None:
    done = CliRunner().invoke(told, ["mine", "--campaign", "paper"])
    assert done.exit_code == 2
    assert "--campaign: expected no CAMPAIGN beside it, got 'mine'; leave one of them out" in done.output
    with pytest.raises(InputError, match="--campaign"):
        choose_campaign("mine", "paper")


@pytest.mark.parametrize("package", ["identification", "uq", "discrepancy", "measurement"])
def test_every_command_with_an_embedded_default_has_the_option(package: str) -> None:
    commands = importlib.import_module(f"haptid.{package}.commands")
    taking = [
        one
        for one in vars(commands).values()
        if isinstance(one, click.Command) and any(p.name == "campaign" for p in one.params)
    ]
    assert taking
    for one in taking:
        assert any("--campaign" in parameter.opts for parameter in one.params)


def test_python_reads_either() -> None:
    assert Campaign.read(embedded="paper").values.folder == embedded_campaign("paper")


def test_planned_tests_come_beside_the_runs_of_the_paper() -> None:
    planned, paper = (read_campaign(embedded_campaign(name)) for name in ("planned", "paper"))
    beside = [run for run in planned.runs if any(locked_posture(run))]
    at_home = [run for run in planned.runs if not any(locked_posture(run))]
    assert beside
    assert [run.file for run in at_home] == [run.file for run in paper.runs]
    for ours, theirs in zip(at_home, paper.runs, strict=True):
        assert (embedded_campaign("planned") / ours.file).read_bytes() == (
            embedded_campaign("paper") / theirs.file
        ).read_bytes()
        assert ours.use == theirs.use
    assert {run.use for run in beside} == {"fit", "validate"}


def test_the_first_posture_of_each_set_of_joints_is_kept() -> None:
    planned, paper = (read_campaign(embedded_campaign(name)) for name in ("planned", "paper"))
    kept = in_first_postures(planned)
    assert [run.file for run in kept.runs] == [run.file for run in paper.runs]
    assert in_first_postures(paper).runs == paper.runs
    turned = tuple(run.but(posture=np.arange(6) / 10) for run in paper.runs_of((3,)))
    assert in_first_postures(paper.but(runs=turned)).runs == turned
