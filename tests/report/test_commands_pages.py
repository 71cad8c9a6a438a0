"""Pages of real results: they parse, their numbers are those of the JSON, text of files stays text."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

from haptid.discrepancy.run import main as discrepancy
from haptid.identification.run import main as identification
from haptid.model.effects.registry import catalogue
from haptid.model.plan import main as plan
from haptid.report.common.numbers import with_error
from haptid.support.numbers import plain
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.identification.bench_joint import TRUE
from tests.report.reading import seen

TITLE = "<script>alert(1)</script> & {{ 7*7 }} ]]>"
FILE = "a<b onload=x>&'{{ 7*7 }}*.csv"
COSINES = (
    Cosine(amplitude=0.005, frequency=1.13, duration=6.0),
    Cosine(amplitude=0.004, frequency=2.4, duration=6.0),
    Cosine(amplitude=0.0045, frequency=1.75, duration=6.0, use="validate"),
)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    made = make_joint_campaign(
        folder, 4, {**TRUE, "Kp": 1.0}, COSINES, sensor=Sensor(noise=2e-4, resolution=1.5e-4), seed=4
    )
    toml = folder / "campaign.toml"
    lines = toml.read_text(encoding="utf-8").splitlines()
    titled = [f"title = {json.dumps(TITLE)}" if line.startswith("title =") else line for line in lines]
    toml.write_text("\n".join(titled) + "\n", encoding="utf-8")
    assert made
    with_hostile_texts(folder)
    return folder


def with_hostile_texts(folder: Path) -> None:
    """Put texts that would be code elsewhere into a file's name, a column's name and a reason."""
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    first = next(line for line in text.splitlines() if line.startswith("file = ")).split('"')[1]
    table = pd.read_csv(folder / first)
    table["<img src=x onerror=alert(3)>"] = 1.0
    table.to_csv(folder / FILE, index=False)
    table.to_csv(folder / f"again_{FILE}", index=False)
    joint = "free_joints = [4]"
    excluded = f'[[runs]]\nfile = "again_{FILE}"\n{joint}\nuse = "excluded"\nreason = {json.dumps(TITLE)}\n'
    path.write_text(f"{text.replace(first, FILE, 1)}\n{excluded}", encoding="utf-8")


def called(command, *arguments) -> None:
    done = CliRunner().invoke(command, [str(a) for a in arguments])
    assert done.exit_code == 0, done.output


def test_the_identification_s_page_has_the_numbers_of_its_json(campaign, tmp_path):
    fast = ("--quiet", "--workers", "1", "--fmu", "none", "--method", "gauss_newton", "--no-export")
    called(identification, campaign, "--out", tmp_path, *fast)
    (one,) = json.loads((tmp_path / "identification.json").read_text(encoding="utf-8"))["configurations"]
    page = seen((tmp_path / "report.html").read_text(encoding="utf-8"))
    for id, entry in one["parameters"].items():
        cells = page.row(id)
        assert with_error(entry["value"], entry["std"]) in cells, id
        assert entry["unit"] in cells or entry["unit"] == "1", id
    for run in one["runs"]:
        cells = page.row(run["file"])
        assert cells[1:4] == [run["use"], f"{run['rmse_rad']:.3g}", f"{run['rmse_over_noise']:.3f}"]
    rows = [[cell.strip() for cell in row] for row in page.rows]
    for run in one["runs"]:
        for name, label in (("model", "fit"), ("baseline", "plain")):
            figures = run["figures"][name]
            (cells,) = [row for row in rows if row[:3] == [run["file"], run["use"], label]]
            told = [figures["free_rmse"], figures["torque_rmse"], 100 * figures["torque_error"]]
            assert cells[3:6] == [plain(x, 3) for x in told]
            assert cells[6] == plain(figures["horizon_rmse"]["0.1"], 3)
    for id, entry in one["baseline"]["parameters"].items():
        assert any(row[:2] == [id, with_error(entry["value"], entry["std"])] for row in rows), id
    assert one["why"] in page.text
    assert TITLE in page.text
    assert "49" not in page.text.split(TITLE)[0]
    assert "SYNTHETIC DATA" in page.text
    assert len(page.pictures) >= 2


def test_the_discrepancy_s_page_has_the_numbers_of_its_json(campaign, tmp_path):
    others = ",".join(sorted({e.id for e in catalogue().values()} - {"cubic_spring"}))
    called(discrepancy, campaign, "--joint", 4, "--out", tmp_path, "--starts", 1, "--without", others, "--quiet")
    found = json.loads((tmp_path / "discrepancy" / "joint4.json").read_text(encoding="utf-8"))
    page = seen((tmp_path / "discrepancy" / "joint4.html").read_text(encoding="utf-8"))
    assert found["sentence"] in page.text
    assert TITLE in page.text
    gap = found["gap"]["validate"]
    told = [f"{1e3 * gap[name]:.3g}" for name in ("before", "after", "noise")]
    assert page.row("runs that no fit saw, which chose among candidates")[1:4] == told
    assert len(page.pictures) >= 2


def test_the_plan_s_page_has_the_numbers_of_its_json(tmp_path):
    called(plan, "double_pendulum", "--no-design", "--out", tmp_path)
    made = json.loads((tmp_path / "locking_plan.json").read_text(encoding="utf-8"))
    page = seen((tmp_path / "locking_plan.html").read_text(encoding="utf-8"))
    for stage in made["stages"]:
        name = "+".join(map(str, stage["free_joints"]))
        assert any(row and row[0].strip() == name for row in page.rows), name
    for entry in made["unidentifiable"]:
        assert page.row(", ".join(entry["what"]))[1] == " ".join(entry["why"].split())
    assert str(made["base_parameters"]["rank_exact"]) in page.text
