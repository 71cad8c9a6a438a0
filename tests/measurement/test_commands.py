import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from haptid.measurement import check, new
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.making.answers import propose_device, propose_validation
from haptid.measurement.naming.lacking_columns import tell_how_to_name


@pytest.fixture
def tables(tmp_path):
    """Two tables with somebody's own column names, in degrees and milliseconds."""
    folder = tmp_path / "tables"
    folder.mkdir()
    t = np.arange(200) * 5.0
    for name, gain in (("one.csv", 1.0), ("two.csv", 2.0)):
        frame = pd.DataFrame({"ms": t, "tau": gain * np.cos(0.02 * t), "deg": 10 * gain * np.sin(0.02 * t)})
        frame.to_csv(folder / name, index=False)
    return folder


MAPS = ["--map", "ms=time_s*0.001", "--map", "tau=torque_2_Nm", "--map", "deg=position_2_rad*0.017453292519943295"]


def run_new(*arguments: object, answers: str | None = None):
    return CliRunner().invoke(new.main, [str(part) for part in arguments], input=answers)


def test_new_from_flags(tables, tmp_path):
    out = tmp_path / "made"
    flags = ["--synthetic", "--title", "Mine", "--noise", "1e-4", "--validate", "two.csv", *MAPS]
    result = run_new(tables, "--out", out, *flags)
    assert result.exit_code == 0, result.output
    campaign = read_campaign(out)
    assert (campaign.title, campaign.label, campaign.joints) == ("Mine", "synthetic", (2,))
    assert [run.use for run in campaign.runs] == ["fit", "validate"]
    assert campaign.noise_given
    original = pd.read_csv(tables / "one.csv")
    np.testing.assert_allclose(campaign.runs[0].y[:, 0], np.deg2rad(original["deg"]), rtol=1e-15)
    np.testing.assert_allclose(campaign.runs[0].t, original["ms"] / 1000, rtol=1e-15)
    assert (tables / "one.csv").read_text().startswith("ms,tau,deg")


def test_new_asks_where_flags_are_absent(tables, tmp_path, monkeypatch):
    monkeypatch.setattr(new, "_can_ask", lambda: True)
    answers = "Asked\n\nbanana\ny\ntwo.csv\n\ntorque_2_Nm\nposition_2_rad*0.0174533\n1e-4\n\n\n"
    result = run_new(tables, "--out", tmp_path / "made", answers=answers)
    assert result.exit_code == 0, result.output
    assert "Error: answer y or n\n" in result.output
    assert "invalid input" not in result.output
    assert "ms is (time_ms, " in result.output
    campaign = read_campaign(tmp_path / "made")
    assert (campaign.title, campaign.device, campaign.measured) == ("Asked", "single_joint", True)
    assert campaign.noise_given
    assert [run.use for run in campaign.runs] == ["fit", "validate"]


def test_new_shows_what_it_estimates_and_understood_before_it_writes(tables, tmp_path, monkeypatch):
    monkeypatch.setattr(new, "_can_ask", lambda: True)
    rng = np.random.default_rng(0)
    for path in tables.iterdir():
        frame = pd.read_csv(path)
        frame["deg"] = np.round((frame["deg"] + rng.normal(0.0, 0.02, len(frame))) / 0.01) * 0.01
        frame.to_csv(path, index=False)
    head = "Asked\n\ny\ntwo.csv\n"
    result = run_new(tables, *MAPS, "--out", tmp_path / "made", answers=head + "nothing\n\n2*pi/4096\nn\n")
    assert result.exit_code == 130
    assert not (tmp_path / "made").exists()
    assert "What is to be changed? (title, device, origin, validation, columns, noise; Ctrl-C" in result.output
    assert result.stderr.endswith("\ninterrupted: nothing was finished yet\n")
    shown, _, asked = result.output.partition("Standard deviation of the position's noise [rad] [estimated: ")
    assert "two.csv: validate, 200 rows, 0.995 s at 200 Hz; joint 2 moves by 0.69" in shown
    low = float(asked.split("]")[0].split(" to ")[0])
    assert 2e-4 < low < 5e-4
    assert "noise: expected a number above 0, as 2e-4 or 2*pi/4096, got 'nothing'" in asked
    assert "Step of the encoder [rad] (as 2*pi/4096) [estimated: 0.00017]" in asked
    result = run_new(tables, *MAPS, "--out", tmp_path / "made", answers=head + "\n2*pi/4096\n\n")
    assert result.exit_code == 0, result.output
    (step,) = {float(run.resolution[0]) for run in read_campaign(tmp_path / "made").runs}
    assert step == pytest.approx(2 * np.pi / 4096)
    assert not read_campaign(tmp_path / "made").noise_given


def test_new_with_yes_asks_nothing_and_says_what_it_assumed(tables, tmp_path, monkeypatch):
    monkeypatch.setattr(new, "_can_ask", lambda: True)
    (tables / "two.csv").rename(tables / "val_two.csv")
    result = run_new(tables, "--out", tmp_path / "made", "--yes", *MAPS)
    assert result.exit_code == 0, result.output
    told = result.output.split("assumed, unless a flag says otherwise:\n")[1].splitlines()[:5]
    assert told == [
        "  the title is 'tables' (--title)",
        "  the device is single_joint (--device)",
        "  the data were measured on a real device (--synthetic)",
        "  kept from every fit: val_two.csv (--validate)",
        "  the position's noise is to be estimated from the data (--noise)",
    ]
    campaign = read_campaign(tmp_path / "made")
    assert (campaign.title, campaign.measured, campaign.noise_given) == ("tables", True, False)
    assert [run.use for run in campaign.runs] == ["fit", "validate"]


def test_new_with_yes_leaves_what_flags_say(tables, tmp_path):
    flags = ["--synthetic", "--title", "Mine", "--noise", "1e-4", "--validate", "one.csv", "--device", "single_joint"]
    result = run_new(tables, "--out", tmp_path / "made", "--yes", *flags, *MAPS)
    assert "assumed" not in result.output
    assert [run.use for run in read_campaign(tmp_path / "made").runs] == ["validate", "fit"]


def test_the_one_device_file_among_the_tables_is_proposed(tables):
    assert propose_device(tables) == "single_joint"
    (tables / "arm.urdf").write_text("<robot/>")
    assert propose_device(tables) == "arm.urdf"
    (tables / "other.toml").write_text("")
    assert propose_device(tables) == "single_joint"


def test_new_warns_of_the_users_folder_and_not_of_its_draft(tables, tmp_path):
    frame = pd.read_csv(tables / "one.csv").assign(humidity=40.0)
    frame.to_csv(tables / "one.csv", index=False)
    result = run_new(tables, "--out", tmp_path / "made", "--measured", *MAPS)
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("warning")]
    assert line == f"warning: {tables}: columns that the format does not know are kept and not used: humidity"


@pytest.mark.parametrize(
    ("maps", "lacking"),
    [
        (["ms=time_s*0.001", "deg=position_2_rad"], "; no torque: use --map 'tau=torque_2_Nm'\n"),
        (["tau=torque_2_Nm", "deg=position_2_rad"], "; no time: use --map 'ms=time_s*0.001'\n"),
        (["deg=position_2_rad"], "; no time, no torque: use --map 'ms=time_s*0.001' --map 'tau=torque_2_Nm'\n"),
        (["ms=time_s*0.001", "tau=torque_2_Nm"], "; no position: use --map 'deg=position_2_rad*0.0174533'\n"),
        (["ms=time_s*0.001", "deg=torque_1_Nm"], "; no position: name a column, as in --map 'tau=position_1_rad'\n"),
        (
            ["ms=time_s*0.001", "tau=torque_1_Nm", "deg=position_2_rad"],
            "; no torque and position of one joint: torques of 1, positions of 2; give both one number by --map\n",
        ),
    ],
)
def test_new_says_which_column_lacks(tables, tmp_path, maps, lacking):
    flags = [word for one in maps for word in ("--map", one)]
    result = run_new(tables, "--out", tmp_path / "made", "--measured", *flags)
    assert result.exit_code == 2
    assert lacking in result.stderr


@pytest.mark.parametrize(
    ("column", "told"),
    [
        ("u (V)", "--map 'u (V)=voltage_2_V'"), ("signal [A]", "--map 'signal [A]=current_2_A'"),
        ("u (%)", "--map 'u (%)=duty_2*0.01'"), ("signal", "--map 'signal=torque_2_Nm'"),
    ],
)  # fmt: skip
def test_a_column_is_proposed_as_what_its_unit_says(column, told):
    columns = ["time_s", column, "position_2_rad"]
    assert told in tell_how_to_name(["torque"], columns, {2}, None)


@pytest.mark.parametrize(
    ("column", "told"),
    [
        ("Angolo (gradi)", "=position_2_rad*0.0174533'"), ("Hoek [gon]", "=position_2_rad*0.015708'"),
        ("Winkel (Winkelgrad)", "=position_2_rad' (radians; degrees: position_2_rad*0.0174533)"),
        ("posrad", "=position_2_rad' (radians; degrees: position_2_rad*0.0174533)"), ("x_rad", "=position_2_rad'"),
    ],
)  # fmt: skip
def test_a_position_is_proposed_in_radians_alone_where_its_name_says_so(column, told):
    assert tell_how_to_name(["position"], ["time_s", column, "torque_2_Nm"], {2}, None).endswith(f"'{column}{told}")


def test_new_remarks_on_degrees_in_a_place_that_no_pipe_takes(tables, tmp_path):
    """The remark on a likely slip was among the lines on stdout."""
    maps = [word.partition("*")[0] if word.startswith("deg") else word for word in MAPS]
    result = run_new(tables, "--out", tmp_path / "made", "--measured", *maps)
    assert result.exit_code == 0, result.output
    assert "travel 40 rad on a revolute joint: degrees? then multiply the position by 0.0174533" in result.stderr
    assert "remark: " not in result.stdout


@pytest.mark.parametrize(
    ("position", "torque", "told"),
    [
        ("Position actual value [mm]", "Actual torque [%]", "a force in N, got 'Actual torque [%]'; state a hundredth"),
        ("Position actual value [mm]", "Motor torque", "; no torque: use --map 'Motor torque=force_0_N'"),
        ("Position actual value [rad]", "Actual torque [0.1%]", "a torque in N m, got 'Actual torque [0.1%]'; state a"),
        ("Position actual value [rad]", "Motor torque", "; no torque: use --map 'Motor torque=torque_0_Nm'"),
    ],
)
def test_what_new_says_of_a_torque_is_obeyed_without_another_error(tables, tmp_path, position, torque, told):
    for path in tables.iterdir():
        named = pd.read_csv(path).set_axis(["Time [ms]", torque, position], axis="columns")
        named.assign(**{position: 0.05 * named[position]}).to_csv(path, index=False)
    refused = run_new(tables, "--out", tmp_path / "made", "--measured")
    assert refused.exit_code == 2
    assert told in refused.stderr
    option = re.search(r"--map '([^']+)'", refused.stderr)[1]
    obeyed = run_new(tables, "--out", tmp_path / "made", "--measured", "--map", option)
    assert obeyed.exit_code == 0, obeyed.output


@pytest.mark.parametrize("name", ["Pot (counts)", "Sensor ADC", "pot_raw", "Hall ticks", "Encoder LSB"])
def test_new_says_that_counts_want_a_factor(tables, tmp_path, name):
    for path in tables.iterdir():
        named = pd.read_csv(path).set_axis(["Time [ms]", "Motor torque [Nm]", name], axis="columns")
        named.assign(**{name: (40 * named[name]).round().astype(int)}).to_csv(path, index=False)
    refused = run_new(tables, "--out", tmp_path / "made", "--measured")
    assert refused.exit_code == 2
    hint = f"--map '{name}=position_0_rad*0.00153398' (if 4096 counts a turn)"
    assert hint in refused.stderr
    # Without the factor the rows are taken, with a remark on counts.
    made = run_new(tables, "--out", tmp_path / "made", "--measured", "--map", f"{name}=position_0_rad")
    assert "counts? then multiply the position by the angle of one" in made.output


def firmware(tables: Path, *names: str) -> None:
    """Log the runs as a firmware does: milliseconds, a demand and an encoder in counts."""
    for path in tables.iterdir():
        read = pd.read_csv(path)
        counts = (40 * read["deg"]).round().astype(int)
        demand = (200 * read["tau"] / read["tau"].abs().max()).round().astype(int)
        columns = {"millis": read["ms"], "pwm": demand, "enc": counts, "setpoint": counts + 1, "current_mA": demand}
        pd.DataFrame({name: columns[name] for name in names}).to_csv(path, index=False)


def test_a_duty_and_an_encoder_in_whole_numbers_get_the_factors_of_their_counts(tables, tmp_path):
    firmware(tables, "millis", "pwm", "enc")
    refused = run_new(tables, "--out", tmp_path / "made", "--measured")
    duty, angle = "pwm=duty_0*0.003922", "enc=position_0_rad*0.00153398"
    notes = "(255 is full) (if 4096 counts a turn)"
    assert f"no torque, no position: use --map '{duty}' --map '{angle}' {notes}\n" in refused.stderr
    made = run_new(tables, "--out", tmp_path / "made", "--measured", "--map", duty, "--map", angle, "--supply", "12")
    assert made.exit_code == 0, made.output
    assert "millis is time_s, × 0.001" in made.output


def test_a_bare_setpoint_is_the_reference_where_it_travels_as_the_position(tables, tmp_path):
    firmware(tables, "millis", "setpoint", "enc", "current_mA")
    flags = ("--out", tmp_path / "made", "--measured", "--torque-constant", "0.4")
    refused = run_new(tables, *flags)
    angle, reference = "enc=position_0_rad*0.00153398", "setpoint=reference_0_rad*0.00153398"
    assert f"no position: use --map '{angle}' --map '{reference}' (if 4096" in refused.stderr
    made = run_new(tables, *flags, "--map", angle)
    assert (
        f"not used: setpoint; where it is what the position is to follow, name it by --map '{reference}'" in made.output
    )


def test_a_setpoint_of_another_size_is_no_reference(tables, tmp_path):
    firmware(tables, "millis", "setpoint", "enc", "current_mA")
    for path in tables.iterdir():
        read = pd.read_csv(path)
        read.assign(setpoint=100 * read["setpoint"]).to_csv(path, index=False)
    refused = run_new(tables, "--out", tmp_path / "made", "--measured", "--torque-constant", "0.4")
    assert "reference_0_rad" not in refused.stderr


@pytest.mark.parametrize(
    ("numbers", "goal", "note"),
    [
        ([0.0, 0.5, -1.0], "duty_0", "a share of the supply"),
        ([0.0, 80.0, -40.0], "duty_0*0.003922", "255 is full; per cent: *0.01"),
        ([0.0, 1000.0], "duty_0*0.0009775", "1023 is full"),
        ([0.5, -99.5], "duty_0*0.01", "per cent of the supply"),
    ],
)
def test_the_largest_number_tells_the_full_of_a_duty(numbers, goal, note):
    told = tell_how_to_name(["torque"], ["time_s", "pwm", "position_0_rad"], [0], lambda _: np.array(numbers))
    assert told == f"no torque: use --map 'pwm={goal}' ({note})"


def test_a_current_in_counts_is_no_position(tables, tmp_path):
    for path in tables.iterdir():
        pd.read_csv(path).set_axis(["Time [ms]", "Current raw", "Winkel"], axis="columns").to_csv(path, index=False)
    refused = run_new(tables, "--out", tmp_path / "made", "--measured", "--map", "Current raw=current_0_A")
    assert "'Winkel=position_0_rad'" in refused.stderr


def test_new_says_everything_that_lacks_at_once(tables, tmp_path):
    for path in tables.iterdir():
        frame = pd.read_csv(path).rename(columns={"ms": "Time (ms)", "tau": "Motor current [A]"})
        frame = frame.assign(**{"Position demand value": frame["deg"]})
        frame[["Time (ms)", "Position demand value", "deg", "Motor current [A]"]].rename(
            columns={"deg": "Position actual value"}
        ).to_csv(path, index=False)
    position = "--map 'Position actual value=position_0_rad'"
    reference = "--map 'Position demand value=reference_0_rad'"
    unit = " (radians; degrees: *0.0174533)"
    also = "; also --torque-constant [N m/A], --measured or --synthetic\n"
    result = run_new(tables, "--out", tmp_path / "made")
    assert result.exit_code == 2
    assert result.stderr.endswith(f"; no position: use {position} {reference}{unit}{also}")
    maps = [f"{option.split(chr(39))[1]}*0.0174533" for option in (position, reference)]
    flags = ["--torque-constant", "0.4", "--measured", "--map", maps[0], "--map", maps[1]]
    assert run_new(tables, "--out", tmp_path / "made", *flags).exit_code == 0


def test_new_refuses_joints_that_the_device_lacks_by_the_users_columns(tables, tmp_path):
    arm = Path(__file__).parents[2] / "docs" / "examples" / "two_joints.urdf"
    maps = [word.replace("_2_", "_7_") for word in MAPS]
    result = run_new(tables, "--out", tmp_path / "made", "--measured", "--device", arm, *maps)
    assert result.exit_code == 2
    assert "one.csv: expected joints 0 to 1 of two_joints.urdf, got joint 7 of column 'deg'" in result.stderr
    assert "campaign.toml" not in result.stderr


@pytest.mark.parametrize(
    ("names", "proposed"),
    [
        (["val_1.csv", "slow.csv", "fast_Validation.csv"], ("val_1.csv", "fast_Validation.csv")),
        (["interval.csv", "valve.csv"], ()),
        (["val_1.csv", "val_2.csv"], ()),
    ],
)
def test_runs_whose_names_say_so_are_proposed_for_validation(names, proposed):
    assert propose_validation(names) == proposed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (MAPS, "--measured or --synthetic: expected one of the two flags, got neither"),
        (["--measured"], "expected columns time_s, torque_<j>_Nm, position_<j>_rad, got ms, tau, deg"),
        (["--measured", *MAPS, "--validate", "three.csv"], "--validate: expected one of one.csv, two.csv"),
        (["--measured", *MAPS, "--map", "x=position_1_rad"], "a column x (named in --map)"),
        (["--measured", "--map", "tau=torque"], "--map: expected COLUMN=NAME"),
        (["--measured", "--map", "tau=torque_2_Nm*x"], "--map: expected a number as the factor"),
        (["--measured", *MAPS, "--device", "robot"], "device: expected a built-in device"),
        (["--measured", *MAPS, "--free", "3"], "expected columns time_s"),
    ],
)
def test_new_refuses_and_writes_nothing(tables, tmp_path, arguments, message):
    result = run_new(tables, "--out", tmp_path / "made", *arguments)
    assert result.exit_code == 2
    assert message in result.output
    assert result.output.strip().count("\n") == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tables"]


CURRENTS = ["--map", "ms=time_s*0.001", "--map", "tau=current_2_A", "--map"]
TURNS, SLIDES = "deg=position_2_rad*0.017453292519943295", "deg=position_2_m*0.001"


def test_a_line_above_the_header_on_the_torque_of_an_ampere_is_told(tables, tmp_path):
    (path,) = tables.glob("one.csv")
    path.write_text("# Motor: 12 V\n# Kt: 0.25 Nm/A\n" + path.read_text())
    refused = run_new(tables, "--out", tmp_path / "made", "--measured", *CURRENTS, TURNS)
    assert refused.exit_code == 2
    assert "got a current alone (one.csv says 'Kt: 0.25 Nm/A'); state it by --torque-constant" in refused.output


@pytest.mark.parametrize(("position", "key"), [(TURNS, "torque_constant_Nm_per_A"), (SLIDES, "force_constant_N_per_A")])
def test_new_takes_a_current_with_the_torque_of_an_ampere(tables, tmp_path, position, key):
    out = tmp_path / "made"
    refused = run_new(tables, "--out", out, "--measured", *CURRENTS, position)
    assert refused.exit_code == 2
    assert (
        "current_2_A: expected the torque of an ampere, got a current alone; state it by --torque-constant"
        in refused.output
    )
    assert not out.exists()
    made = run_new(tables, "--out", out, "--measured", *CURRENTS, position, "--torque-constant", "0.25")
    assert made.exit_code == 0, made.output
    assert f"{key} = 0.25" in (out / "campaign.toml").read_text()
    original = pd.read_csv(tables / "one.csv")
    np.testing.assert_allclose(read_campaign(out).runs[0].u[:, 0], 0.25 * original["tau"], rtol=1e-15)


def test_new_says_how_each_of_several_motors_gets_its_constant(tables, tmp_path):
    """One number was taken for all motors, and nothing said so."""
    for path in tables.iterdir():
        frame = pd.read_csv(path)
        motors = {
            "I0 (A)": frame["tau"],
            "I1 (mA)": 1e3 * frame["tau"],
            "q0 (deg)": frame["deg"],
            "q1 (deg)": frame["deg"],
        }
        pd.DataFrame({"t (ms)": frame["ms"], **motors}).to_csv(path, index=False)
    own = ["I0 (A)=torque_0_Nm*0.4", "I1 (mA)=torque_1_Nm*0.0004"]
    start = (tables, "--out", tmp_path / "made", "--measured", "--device", "double_pendulum")
    refused = run_new(*start)
    each = " ".join(f"--map '{one}'" for one in own)
    assert refused.exit_code == 2
    assert f"--torque-constant [N m/A] where it is that of all motors, or each by {each}" in refused.stderr
    alike = run_new(*start, "--torque-constant", "0.4")
    assert alike.exit_code == 0, alike.output
    told = f"  an ampere gives 0.4 N m (N) at each of joints 0, 1 (each its own: --map '{own[1]}')"
    assert told in alike.output.split("assumed, unless a flag says otherwise:\n")[1].splitlines()
    start = (tables, "--out", tmp_path / "other", "--measured", "--device", "double_pendulum")
    stated = run_new(*start, "--map", own[0], "--map", "I1 (mA)=torque_1_Nm*0.0002")
    assert stated.exit_code == 0, stated.output
    assert "ampere" not in stated.output
    run, other = read_campaign(tmp_path / "other").runs[0], read_campaign(tmp_path / "made").runs[0]
    np.testing.assert_allclose(run.u * [1.0, 2.0], other.u, rtol=1e-12)


@pytest.mark.parametrize(("constant", "told"), [("-0.25", True), ("0.25", False)])
def test_new_remarks_on_a_constant_that_turns_the_sign(tables, tmp_path, constant, told):
    made = run_new(tables, "--out", tmp_path / "made", "--measured", *CURRENTS, TURNS, "--torque-constant", constant)
    assert made.exit_code == 0, made.output
    sentence = "remark: --torque-constant -0.25 is below 0: the torque has the opposite sign of the recorded current"
    assert (sentence in made.output) is told


def test_new_asks_for_the_torque_of_an_ampere(tables, tmp_path, monkeypatch):
    monkeypatch.setattr(new, "_can_ask", lambda: True)
    answers = "Asked\n\ny\ntwo.csv\ntime_s*0.001\ncurrent_2_A\nposition_2_rad*0.0174533\nmany\n0.25\n1e-4\n\n\n"
    result = run_new(tables, "--out", tmp_path / "made", answers=answers)
    assert result.exit_code == 0, result.output
    assert "torque of an ampere: expected a number, not 0, got 'many'" in result.output
    assert "torque_constant_Nm_per_A = 0.25" in (tmp_path / "made" / "campaign.toml").read_text()


@pytest.fixture
def duties(tables):
    """Tables of a duty, without its supply."""
    for path in tables.iterdir():
        frame = pd.read_csv(path)
        frame.rename(columns={"ms": "time (ms)", "tau": "duty (%)", "deg": "angle (deg)"}).to_csv(path, index=False)
    return tables


def test_new_takes_the_supply_of_a_duty(duties, tmp_path):
    result = run_new(duties, "--out", tmp_path / "made", "--yes")
    assert result.exit_code == 2
    assert "one.csv: expected the supply of which a duty is a share, got a duty alone; state" in result.stderr
    assert "--supply [V]" in result.stderr
    result = run_new(duties, "--out", tmp_path / "made", "--yes", "--supply", "24")
    assert result.exit_code == 0, result.output
    run = read_campaign(tmp_path / "made").runs[0]
    assert np.all(run.drive_inputs["supply"] == 24.0)
    assert np.abs(run.drive_inputs["duty"]).max() == pytest.approx(0.01)


def test_new_asks_what_drives_the_joint_where_only_that_is_unknown(tables, tmp_path, monkeypatch):
    monkeypatch.setattr(new, "_can_ask", lambda: True)
    for path in tables.iterdir():
        read = pd.read_csv(path)
        read.rename(columns={"ms": "millis", "tau": "pwm", "deg": "angle_deg"}).to_csv(path, index=False)
    flags = ["--measured", "--title", "D", "--device", "single_joint", "--validate", "two.csv", "--noise", "1e-4"]
    result = run_new(tables, "--out", tmp_path / "made", *flags, answers="duty_0*0.01\n12\n")
    assert result.exit_code == 0, result.output
    assert "pwm is (duty_0; a share of the supply): duty" in result.output
    assert "millis is (" not in result.output


def test_new_asks_for_the_supply_of_a_duty(duties, tmp_path, monkeypatch):
    monkeypatch.setattr(new, "_can_ask", lambda: True)
    flags = ["--measured", "--title", "D", "--device", "single_joint", "--validate", "two.csv", "--noise", "1e-4"]
    result = run_new(duties, "--out", tmp_path / "made", *flags, answers="0\n12\n")
    assert result.exit_code == 0, result.output
    assert np.all(read_campaign(tmp_path / "made").runs[0].drive_inputs["supply"] == 12.0)


@pytest.mark.parametrize(("volts", "told"), [("-1", "a number of volts above 0"), ("12", "a duty without a column")])
def test_new_refuses_a_supply_that_says_nothing(tables, tmp_path, volts, told):
    result = run_new(tables, "--out", tmp_path / "made", "--measured", "--supply", volts, *MAPS)
    assert result.exit_code == 2
    assert f"--supply: expected {told}" in result.stderr


def test_new_takes_a_time_without_unit_for_seconds_and_says_so(tables, tmp_path):
    for path in tables.iterdir():
        frame = pd.read_csv(path)
        frame.assign(ms=frame["ms"] / 1000).rename(columns={"ms": "Time"}).to_csv(path, index=False)
    result = run_new(tables, "--out", tmp_path / "made", "--measured", *MAPS[2:])
    assert result.exit_code == 0, result.output
    assert "  'Time' is in seconds (in milliseconds: --map 'Time=time_s*0.001')\n" in result.stdout
    assert read_campaign(tmp_path / "made").runs[0].t[1] == pytest.approx(0.005)
    result = run_new(tables, "--out", tmp_path / "other", "--measured", "--map", "Time=time_s*0.001", *MAPS[2:])
    assert "in seconds" not in result.stdout
    assert read_campaign(tmp_path / "other").runs[0].t[1] == pytest.approx(5e-6)


def test_new_says_what_a_spreadsheet_has_to_become(tables, tmp_path):
    for path in tables.iterdir():
        path.rename(path.with_suffix(".XLSX"))
    result = run_new(tables, "--out", tmp_path / "made", "--measured")
    assert result.exit_code == 2
    assert re.search(
        r"one\.XLSX: expected tables that end in \.csv.*, got a spreadsheet; save it as CSV$", result.stderr
    )


def test_new_does_not_overwrite(tables, folder):
    before = folder.toml.read_bytes()
    result = run_new(tables, "--out", folder.path, "--measured", *MAPS)
    assert result.exit_code == 2
    assert "expected a new or empty folder" in result.output
    assert folder.toml.read_bytes() == before


def test_new_with_tables_that_hold_other_joints_too(tables, tmp_path):
    for path in tables.iterdir():
        pd.read_csv(path).assign(torque_0_Nm=0.0, position_0_rad=0.1).to_csv(path, index=False)
    result = run_new(tables, "--out", tmp_path / "made", "--measured", *MAPS, "--free", "2")
    assert result.exit_code == 0, result.output
    assert read_campaign(tmp_path / "made").joints == (2,)


def run_check(*arguments: object):
    return CliRunner().invoke(check.main, [str(part) for part in arguments])


def test_check_prints_runs_and_remarks(folder):
    folder.replace('use = "validate"', 'use = "excluded"\nreason = "the cable slipped"')
    result = run_check(folder.path)
    assert result.exit_code == 0, result.output
    assert "A test" in result.stdout
    assert "synthetic data" in result.stdout
    assert "no validation run for 4" in result.stdout
    assert "excluded: the cable slipped" in result.stdout
    row = next(line for line in result.stdout.splitlines() if line.startswith("a.csv"))
    assert row.split()[:6] == ["a.csv", "4", "fit", "40", "0.195", "200"]
    assert "0.0002" in row


def test_check_warns_on_stderr_in_one_line(folder):
    folder.frame.assign(temperature=20.5).to_csv(folder.path / "a.csv", index=False)
    result = run_check(folder.path)
    assert result.exit_code == 0
    assert result.stderr.startswith("warning: ")
    assert result.stderr.count("\n") == 1


def test_check_refuses_bad_input_in_one_line(folder):
    folder.line(7, "0.025,NaN,0.1")
    result = run_check(folder.path)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1


@pytest.mark.real("dvrk_mtm_joint4")
def test_check_sees_position_control_in_the_real_tendon_joint(shared):
    result = run_check(shared / "dvrk_mtm_joint4")
    assert result.exit_code == 0
    assert "recorded under position control" in result.stdout


@pytest.mark.real("dfki_double_pendulum_a0")
def test_check_of_the_real_arm_finds_open_loop_and_the_encoder_step(shared):
    result = run_check(shared / "dfki_double_pendulum_a0")
    assert result.exit_code == 0
    assert "position control" not in result.stdout
    assert "~0.00038" in result.stdout
