"""What ``haptid init`` asks on a terminal: what lacks again, and what the user wants to change."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

from haptid.measurement import check, new
from haptid.measurement.format.reading import read_campaign

T = np.arange(400) * 0.005
FACTS = "Mine\n\n\n\n"
"""Replies on title, device, origin and validation."""
SENSOR = "\n\n"


@pytest.fixture
def tables(tmp_path: Path) -> Path:
    """Two tables whose names say the time alone."""
    folder = tmp_path / "tables"
    folder.mkdir()
    for name in ("one", "two"):
        frame = pd.DataFrame({"time_s": T, "foo": np.cos(3 * T), "bar": 0.3 * np.sin(3 * T)})
        frame.to_csv(folder / f"{name}.csv", index=False)
    return folder


@pytest.fixture
def talk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Run the command on a terminal with these replies."""

    def run(folder: Path, replies: str, *flags: str) -> Result:
        monkeypatch.setattr(new, "_can_ask", lambda: True)
        return CliRunner().invoke(new.main, [str(folder), "--out", str(tmp_path / "made"), *flags], input=replies)

    return run


def test_columns_that_bare_enters_left_open_are_asked_again(tables: Path, talk):
    done = talk(tables, FACTS + "\n\n" + "torque_0_Nm\n\n" + "position_0_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    lacks = "lacks what drives the joint (a torque, current, voltage or duty) and a position."
    assert f"one.csv {lacks} It has the columns time_s, foo, bar." in done.output
    assert f"one.csv still {lacks} Ctrl-C leaves without writing.\nfoo is (torque_0_Nm" in done.output
    # The column that has its reply is not asked a third time.
    assert "one.csv still lacks a position. Ctrl-C leaves without writing.\nbar is (position_0_rad, " in done.output
    assert "time_s is" not in done.output
    np.testing.assert_allclose(read_campaign(tables.parent / "made").runs[0].u[:, 0], np.cos(3 * T))


def test_a_unit_that_is_not_understood_is_not_taken_for_radians(tables: Path, talk):
    """The angle was proposed in radians to a bare Enter."""
    for path in tables.iterdir():
        path.write_text(path.read_text().replace("foo", "Moment (Nm)").replace("bar", "Winkel (Winkelgrad)"))
    done = talk(tables, FACTS + "\nposition_0_deg\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    asked = "Winkel (Winkelgrad) is (position_0_rad; radians; degrees: position_0_rad*0.0174533"
    assert done.output.count(asked) == 2
    assert np.ptp(read_campaign(tables.parent / "made").runs[0].y) == pytest.approx(np.radians(0.6), rel=0.01)


def test_torque_and_position_of_two_joints_are_asked_again_with_the_replies_as_proposals(tables: Path, talk):
    done = talk(tables, FACTS + "torque_0_Nm\nposition_1_rad\n" + "\nposition_0_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert "torques of 0, positions of 1; give both one number\nfoo is (" in done.output
    assert "leaves it unused; back asks for bar again) [torque_0_Nm]: \nbar is (" in done.output
    assert read_campaign(tables.parent / "made").joints == (0,)


def test_back_asks_for_the_column_before_once_more(tables: Path, talk):
    """A wrong role could be taken back at the end alone."""
    done = talk(tables, FACTS + "position_0_rad\nback\ntorque_0_Nm\nposition_0_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    asked = [line for line in done.output.splitlines() if line.startswith(("foo is", "bar is"))]
    assert [line[:3] for line in asked] == ["foo", "bar", "foo", "bar"]
    assert all(("; back asks for foo again)" in line) == line.startswith("bar") for line in asked)
    assert "[position_0_rad]" in asked[2]  # the reply that was taken back is proposed again
    np.testing.assert_allclose(read_campaign(tables.parent / "made").runs[0].u[:, 0], np.cos(3 * T))


def test_back_tells_of_a_column_of_any_name(tables: Path, talk):
    """A word stood for the question before the columns, and a column may be called so."""
    for path in tables.iterdir():
        path.write_text(path.read_text().replace("foo", "the question before", 1))
    done = talk(tables, FACTS + "torque_0_Nm\nposition_0_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert "; back asks for the question before again)" in done.output


def test_back_goes_back_beyond_what_a_table_still_lacks(tables: Path, talk):
    wrong = "position_0_rad\n\n"  # bar stays open, is asked for once more, and leads back to foo
    done = talk(tables, FACTS + wrong + "back\nback\ntorque_0_Nm\n\n" + "position_0_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    np.testing.assert_allclose(read_campaign(tables.parent / "made").runs[0].u[:, 0], np.cos(3 * T))


def test_back_leads_from_the_columns_to_the_facts_before_them(tables: Path, talk):
    """The runs to keep, then the device, are asked once more, with the replies as the proposals."""
    kept = "Mine\n\n\none.csv\n"
    done = talk(
        tables, kept + "back\nback\nback\n" + "\n\ntwo.csv\n" + "torque_0_Nm\nposition_0_deg\n" + SENSOR + "y\n"
    )
    assert done.exit_code == 0, done.output
    assert "separated by spaces; - none) [one.csv]: back" in done.output
    campaign = read_campaign(tables.parent / "made")
    assert {run.file: run.use for run in campaign.runs} == {"one.csv": "fit", "two.csv": "validate"}
    assert np.ptp(campaign.runs[0].y) == pytest.approx(np.radians(0.6), rel=0.01)


def test_back_is_no_reply_to_the_first_question(tables: Path, talk):
    done = talk(tables, "back\nMine\nback\nOther\n\n\n\n" + "torque_0_Nm\nposition_0_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert read_campaign(tables.parent / "made").title == "Other"


def test_back_leads_from_the_end_to_the_step_the_noise_and_the_last_column(tables: Path, talk):
    """The earlier replies are proposed again, the number of a noise too."""
    columns = FACTS + "torque_0_Nm\nposition_0_rad\n"
    done = talk(tables, columns + "1e-3\n\nback\nback\nback\nposition_0_deg\n" + "\n\n" + "y\n")
    assert done.exit_code == 0, done.output
    asked = [line.partition(" ")[0] for line in done.output.splitlines() if line.startswith(("bar is", "foo is"))]
    assert asked == ["foo", "bar", "bar"]
    assert "noise [rad]; - estimates it [0.001]: back" in done.output
    run = read_campaign(tables.parent / "made").runs[0]
    assert np.ptp(run.y) == pytest.approx(np.radians(0.6), rel=0.01)


def test_back_does_not_take_back_a_correction_of_columns(tables: Path, talk):
    """A factor that was corrected at the end was lost on the way back to the noise and beyond."""
    wrong = FACTS + "torque_0_Nm\nposition_0_rad\n" + SENSOR + "n\ncol\n\n\nposition_0_deg\n"
    done = talk(tables, wrong + "back\nback\nback\n" + "\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert np.ptp(read_campaign(tables.parent / "made").runs[0].y) == pytest.approx(np.radians(0.6), rel=0.01)


@pytest.mark.parametrize("way", ["back\n", "title\nback\n", "columns\nback\n"])
def test_back_from_a_change_leaves_all_as_it_is(tables: Path, talk, way: str):
    done = talk(tables, FACTS + "torque_0_Nm\nposition_0_rad\n" + SENSOR + "n\n" + way + "y\n")
    assert done.exit_code == 0, done.output
    assert done.output.count("Title [") == 1 + ("title" in way)
    assert read_campaign(tables.parent / "made").title == "Mine"


def test_back_is_a_reply_where_all_columns_are_changed(tables: Path, talk):
    changes = "n\ncol\n\nposition_0_rad\nback\ntorque_0_Nm\nposition_0_rad\n"
    done = talk(tables, FACTS + "position_0_rad\ntorque_0_Nm\n" + SENSOR + changes + "y\n")
    assert done.exit_code == 0, done.output
    np.testing.assert_allclose(read_campaign(tables.parent / "made").runs[0].u[:, 0], np.cos(3 * T))


@pytest.mark.parametrize("reply", ["position_0_rad*0.02", "nothing", "torque_0_Nm*x"])
def test_a_reply_that_cannot_be_is_asked_again(tables: Path, talk, reply: str):
    done = talk(tables, FACTS + f"position_0_rad\n{reply}\ntorque_0_Nm\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert done.output.count("Error: ") == 1


def test_a_noise_beyond_the_travel_is_asked_again(tables: Path, talk):
    done = talk(tables, FACTS + "torque_0_Nm\nposition_0_rad\n" + "5\n0.001\n0.6\n\ny\n")
    assert done.exit_code == 0, done.output
    assert "noise: expected less than the travel of 0.6, got '5'; in rad or m?" in done.output
    assert "step: expected less than the travel of 0.6, got '0.6'; in rad or m?" in done.output
    assert read_campaign(tables.parent / "made").runs[0].noise[0] == 0.001


def test_a_no_asks_what_is_to_be_changed_and_only_that(tables: Path, talk):
    columns = "position_0_rad\ntorque_0_Nm\n"
    changes = (
        "n\ncol\n\ntorque_0_Nm\nposition_0_rad\n" + "n\nTitle\nOther\n" + "no\nval\ntwo.csv\n" + "n\nnoi\n1e-4\n\n"
    )
    done = talk(tables, FACTS + columns + SENSOR + changes + "y\n")
    assert done.exit_code == 0, done.output
    assert "foo is (- leaves it unused; back asks for time_s again) [position_0_rad]: torque_0_Nm" in done.output
    assert "Title [Mine]: Other" in done.output
    campaign = read_campaign(tables.parent / "made")
    assert (campaign.title, campaign.noise_given) == ("Other", True)
    assert [run.use for run in campaign.runs] == ["fit", "validate"]
    np.testing.assert_allclose(campaign.runs[0].u[:, 0], np.cos(3 * T))
    assert done.output.count("Were the data measured") == 1


def test_a_column_may_be_left_unused_though_its_name_was_understood(tables: Path, talk):
    for path in tables.iterdir():
        pd.read_csv(path).rename(columns={"foo": "torque (Nm)"}).to_csv(path, index=False)
    changes = "n\ncolumns\n\n-\n\n" + "\ntorque (Nm)\n-\n"
    done = talk(tables, FACTS + "position_0_rad\n" + SENSOR + changes)
    assert "torque (Nm) is (- leaves it unused; back asks for time_s again) [torque_0_Nm]: -" in done.output
    assert "one.csv lacks what drives the joint" in done.output


def test_a_device_without_the_joint_is_asked_again(tables: Path, talk):
    columns = "torque_7_Nm\nposition_7_rad\n"
    done = talk(tables, "Mine\nfreedom6s\n\n\n" + columns + "device\nsingle_joint\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert "Error: one.csv: expected joints 0 to 5 of freedom6s, got joint 7 of column 'bar'" in done.output
    assert read_campaign(tables.parent / "made").device == "single_joint"


def test_a_time_whose_rows_tell_its_unit_is_not_asked_for(tables: Path, talk):
    for path in tables.iterdir():
        frame = pd.read_csv(path).rename(columns={"time_s": "stamp"})
        frame.assign(stamp=1000 * frame["stamp"]).to_csv(path, index=False)
    done = talk(tables, FACTS + "torque_0_Nm\nposition_0_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert "'stamp' is in milliseconds (in seconds: --map 'stamp=time_s')" in done.output
    np.testing.assert_allclose(read_campaign(tables.parent / "made").runs[0].t, T, atol=1e-12)


def test_tables_without_a_column_that_could_be_asked_for_are_refused(tables: Path, talk):
    for path in tables.iterdir():
        pd.read_csv(path).rename(columns={"foo": "position_0_rad"}).drop(columns="bar").to_csv(path, index=False)
    done = talk(tables, FACTS)
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "no torque: add torque_0_Nm" in done.stderr


def test_the_noise_below_an_encoder_step_is_told_as_check_tells_it(tables: Path, talk):
    step, turned = 2 * np.pi / 256, 0.3 * np.sin(0.8 * T)  # so slow that the readings rest on each level
    for path in tables.iterdir():
        columns = {"time_s": T, "torque_0_Nm": np.cos(0.8 * T), "position_0_rad": np.round(turned / step) * step}
        pd.DataFrame(columns).to_csv(path, index=False)
    done = talk(tables, FACTS + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    asked = re.search(r"position's noise \[rad\] \[estimated: (\S+)\]", done.output)
    assert asked is not None
    assert asked[1] == f"<{step / 12**0.5:.2g}"
    shown = CliRunner().invoke(check.main, [str(tables.parent / "made")]).output
    assert f" {asked[1]} " in shown


def test_columns_are_proposed_for_the_joints_that_their_names_name(tables: Path, talk):
    """Without units no name is understood; an elbow's torque was proposed as that of joint 0."""
    for path in tables.iterdir():
        columns = {"shoulder torque": np.cos(3 * T), "elbow torque": np.cos(2 * T)}
        columns |= {"shoulder angle": 0.3 * np.sin(3 * T), "elbow angle": 0.2 * np.sin(2 * T)}
        pd.DataFrame({"time_s": T, **columns}).to_csv(path, index=False)
    done = talk(tables, "Mine\ndouble_pendulum\n\n\n" + "\n\n" + "position_0_rad\nposition_1_rad\n" + SENSOR + "y\n")
    assert done.exit_code == 0, done.output
    assert re.search(r"elbow torque is \(.*\[torque_1_Nm\]", done.output)
    (run, *_) = read_campaign(tables.parent / "made").runs
    assert run.free_joints == (0, 1)
    np.testing.assert_allclose(run.u[:, 1], np.cos(2 * T))


def test_the_counts_of_a_turn_are_proposed_from_the_line_above_the_header(tables: Path, talk):
    for path in tables.iterdir():
        counts = np.round(300 * np.sin(3 * T)).astype(int)
        frame = pd.DataFrame({"time_s": T, "torque_0_Nm": np.cos(3 * T), "encoder counts": counts})
        path.write_text("# rig 3\n# counts per turn: 4096\n" + frame.to_csv(index=False))
    done = talk(tables, FACTS + "\n" + "\n" + "y\n")
    assert done.exit_code == 0, done.output
    assert "(as 2*pi/4096; one.csv says 'counts per turn: 4096') [2*pi/4096]" in done.output
    assert np.ptp(read_campaign(tables.parent / "made").runs[0].y) == pytest.approx(600 * 2 * np.pi / 4096)


def test_different_counts_of_a_turn_are_shown_and_none_is_proposed(tables: Path, talk):
    for path, number in zip(sorted(tables.iterdir()), (4096, 8192), strict=True):
        counts = np.round(300 * np.sin(3 * T)).astype(int)
        frame = pd.DataFrame({"time_s": T, "torque_0_Nm": np.cos(3 * T), "encoder counts": counts})
        path.write_text(f"# counts per turn: {number}\n" + frame.to_csv(index=False))
    done = talk(tables, FACTS + "2*pi/8192\n" + "\n" + "y\n")
    assert done.exit_code == 0, done.output
    (asked,) = [line for line in done.output.splitlines() if line.startswith("Angle of one encoder count")]
    assert (
        "one.csv says 'counts per turn: 4096'; two.csv says 'counts per turn: 8192'; the reply holds for all" in asked
    )
    assert "): 2*pi/8192" in asked


@pytest.mark.parametrize(
    ("line", "reply", "shown"),
    [
        ("encoder: 1024 lines, quadrature x4", "\n", ", which is 1024 × 4) [2*pi/4096]: "),
        ("encoder: 1024 lines", "2*pi/4096\n", ", which may be 4096 or 2048 or 1024): 2*pi/4096"),
    ],
)
def test_lines_of_an_encoder_are_proposed_or_quoted(tables: Path, talk, line: str, reply: str, shown: str):
    for path in tables.iterdir():
        counts = np.round(300 * np.sin(3 * T)).astype(int)
        frame = pd.DataFrame({"time_s": T, "torque_0_Nm": np.cos(3 * T), "encoder counts": counts})
        path.write_text(f"# {line}\n" + frame.to_csv(index=False))
    done = talk(tables, FACTS + reply + "\n" + "y\n")
    assert done.exit_code == 0, done.output
    assert f"(as 2*pi/4096; one.csv says {line!r}{shown}" in done.output
    assert np.ptp(read_campaign(tables.parent / "made").runs[0].y) == pytest.approx(600 * 2 * np.pi / 4096)
