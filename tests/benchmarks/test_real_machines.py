"""Real machines: page and README say what the stored results hold, and the aims are judged rightly."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

from benchmarks.machines.campaigns import write_emps, write_xl330
from benchmarks.machines.commands import identify
from benchmarks.machines.figure import Figure
from benchmarks.machines.page import page_of, readme_text, short_name
from benchmarks.machines.sets import SETS
from benchmarks.real_machines import RESULTS, STORED, main
from docs.parts.tables import with_parts
from haptid.support.installing.environment import ROOT

DATA = json.loads(STORED.read_text(encoding="utf-8"))
FIGURES = [(one["folder"], figure) for one in DATA["sets"] for figure in one["figures"]]


def rows_of(page: str) -> list[list[str]]:
    lines = [line for line in page.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_the_page_is_that_of_the_stored_results():
    assert STORED.with_suffix(".md").read_text(encoding="utf-8") == page_of(DATA)


def test_readme_names_the_stored_figures():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    parts = {"real machines": readme_text(DATA)}
    assert text == with_parts(text, parts, "benchmarks/real_machines.py")
    trusted = text.partition("## What to trust")[2].partition("\n## ")[0]
    told = rows_of(trusted)[2:]
    assert len(told) == len(FIGURES)
    for (name, reached, _, met), (_, figure) in zip((row[1:] for row in told), FIGURES, strict=True):
        assert name == short_name(figure["name"])
        if isinstance(figure["reached"], float):
            assert float(reached.split()[0]) == pytest.approx(figure["reached"], rel=5e-2)
            assert (float(reached.split()[0]) <= figure["aim"]) == (met == "yes") == figure["met"]
    assert f"{sum(row[4] == 'yes' for row in told)} of {len(told)} figures" in trusted


@pytest.mark.parametrize(("folder", "figure"), FIGURES, ids=lambda x: x if isinstance(x, str) else x["name"])
def test_each_figure_of_the_page_is_that_of_the_results(folder: str, figure: dict):
    page = STORED.with_suffix(".md").read_text(encoding="utf-8")
    (row,) = [row for row in rows_of(page) if row[:2] == [folder, figure["name"]]]
    aim, published, reached, met = row[2:]
    numbers = ((reached, figure["reached"]), (published, figure["published"]), (aim.removeprefix("≤ "), figure["aim"]))
    for told, value in numbers:
        if isinstance(value, float):
            assert float(told.split()[0]) == pytest.approx(value, rel=5e-3)
    if isinstance(figure["aim"], float) and figure["reached"] is not None:
        assert met == ("yes" if figure["reached"] <= figure["aim"] else "no")
    if figure["reached"] is None:
        assert (reached, met) == ("no result", "-")


def test_each_error_of_a_run_is_that_of_the_results():
    page = STORED.with_suffix(".md").read_text(encoding="utf-8")
    for one in DATA["sets"]:
        section = page.partition(f"## {one['title']}\n")[2].partition("\n## ")[0]
        rows = rows_of(section)
        for run in one["identification"]["runs"] if one["identification"] else ():
            for name, label in (("model", "fit"), ("baseline", "plain model")):
                (row,) = [row for row in rows if row[:3] == [run["file"], run["use"], label]]
                errors = run["figures"][name]["torque_error"]
                told = [float(x) for x in row[5].split(",")]
                assert told == pytest.approx(errors if isinstance(errors, list) else [errors], rel=5e-3)


def test_every_set_is_stored_with_date_version_and_picture():
    assert [one["folder"] for one in DATA["sets"]] == [machine.folder for machine in SETS]
    for one in DATA["sets"]:
        assert one["date"]
        assert one["version"]
        if one["picture"]:
            assert (RESULTS / one["picture"]).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("aim", "reached", "met"),
    [
        (4.0, 3.9, True),
        (4.0, 4.1, False),
        (4.0, None, None),
        (("a", "b"), ["c", "b"], True),
        (("a",), [], False),
        (("a",), None, None),
    ],
)
def test_an_aim_is_judged(aim, reached, met):
    assert Figure(name="x", unit="m", aim=aim, reached=reached).met is met


def test_absent_measurements_are_one_line(tmp_path: Path):
    done = CliRunner().invoke(main, [str(tmp_path / "none")])
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()
    assert "HAPTID_DATA" in line


def test_a_servo_s_duty_is_its_firmware_s_loop(tmp_path: Path):
    source, out = tmp_path / "source", tmp_path / "out"
    source.mkdir()
    out.mkdir()
    rows = "time_s,goal_rad,position_rad,velocity_rad_s,load_raw,supply_V,temperature_C,torque_enabled\n"
    rows += "0.0,0.1,0.0,0,0,7.4,30,1\n0.1,9.0,0.0,0,0,7.4,30,1\n0.2,9.0,0.0,0,0,7.4,30,0\n"
    (source / "kp400_sin.csv").write_text(rows, encoding="utf-8")
    write_xl330(source, out)
    duty = pd.read_csv(out / "kp400_sin.csv")["duty_0"].tolist()
    # A unit of the encoder is 2π/4096 rad, and the firmware divides gain times error by 256·885.
    assert duty == pytest.approx([400 * 0.1 * 4096 / (2 * math.pi) / (256 * 885), 1.0, 0.0])
    run = tomllib.loads((out / "campaign.toml").read_text(encoding="utf-8"))["runs"][0]
    assert run["use"] == "validate"
    assert run["controller_gain"] == pytest.approx(1.151, rel=1e-3)


def test_a_drive_s_force_is_its_voltage_times_the_published_factor(tmp_path: Path):
    for name in ("sweep.csv", "pulses.csv"):
        rows = "time_s,drive_V,reference_m,position_m\n0.0,2.0,0.1,0.0\n0.001,-1.0,0.1,0.001\n"
        (tmp_path / name).write_text(rows, encoding="utf-8")
    out = tmp_path / "out"
    out.mkdir()
    write_emps(tmp_path, out)
    assert pd.read_csv(out / "pulses.csv")["force_0_N"].tolist() == pytest.approx([70.3013, -35.15065], rel=1e-5)


def test_a_refused_campaign_is_stored_with_its_line_and_without_a_folder(tmp_path: Path):
    (tmp_path / "campaign.toml").write_text("[campaign\n", encoding="utf-8")
    called = identify(tmp_path, tmp_path / "out", 60.0)
    assert called.result is None
    assert "campaign.toml" in called.outcome
    assert str(tmp_path) not in called.outcome
