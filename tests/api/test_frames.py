"""Campaigns from data frames: the same runs as from files, the same checks, errors that name run, row and column."""

from __future__ import annotations

import subprocess
import sys
from datetime import timedelta, timezone
from inspect import signature
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tomli_w
from click.testing import CliRunner

import haptid
from haptid import Campaign, FitOptions, Identified, InputError
from haptid.command_line import main
from haptid.identification.job.job import Job
from haptid.identification.run import main as identify
from haptid.measurement.values.warning import CampaignWarning
from haptid.model.device.reader import load_device
from haptid.support.installing import extras
from haptid.support.installing.environment import ROOT
from tests.identification.plain_joint import plain_run

QUICK = FitOptions(method="gauss_newton", starts=1)


def frame_of(seed: int, joint: int = 0) -> pd.DataFrame:
    run = plain_run(seed, seconds=4.0)
    columns = (f"Torque {joint} (Nmm)", f"Angle {joint} (deg)")
    angle = np.degrees(run.y[:, 0])
    return pd.DataFrame({"t (ms)": 1e3 * run.t, columns[0]: 1e3 * run.u[:, 0], columns[1]: angle})


@pytest.fixture(scope="module")
def frames() -> dict[str, pd.DataFrame]:
    return {"a": frame_of(1), "b": frame_of(2), "c": frame_of(3)}


@pytest.fixture(scope="module")
def folder(frames, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same tables as a campaign that ``haptid init`` made."""
    tables, out = tmp_path_factory.mktemp("tables"), tmp_path_factory.mktemp("made") / "campaign"
    for name, frame in frames.items():
        frame.to_csv(tables / f"{name}.csv", index=False)
    made = CliRunner().invoke(
        main, ["init", str(tables), "--out", str(out), "--synthetic", "--validate", "c.csv", "--title", "plain"]
    )
    assert made.exit_code == 0, made.output
    return out


def test_frames_are_the_runs_of_their_files(frames, folder):
    here = Campaign.from_frames(frames, validate=["c"], measured=False, title="plain")
    there = Campaign.read(folder)
    assert [run.use for run in here.runs] == [run.use for run in there.runs] == ["fit", "fit", "validate"]
    for one, other in zip(here.runs, there.runs, strict=True):
        assert f"{one.file}.csv" == other.file
        for name in ("t", "u", "y", "noise", "resolution"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert here.remarks == tuple(remark.replace(".csv", "") for remark in there.remarks)
    assert len(here.summary()) == 3


@pytest.mark.long
def test_a_call_and_the_command_give_the_same_numbers(folder, tmp_path):
    options = ["--fmu", "none", "--method", "gauss_newton", "--starts", "1", "--no-export", "--quiet", "--workers", "1"]
    done = CliRunner().invoke(identify, [str(folder), "--out", str(tmp_path), *options])
    assert done.exit_code == 0, done.output
    called = Campaign.read(folder).identify(kind=None, options=QUICK)
    stored = Identified.read(tmp_path)
    assert stored.summary().equals(called.summary())
    assert stored.runs().equals(called.runs())
    assert called.outcomes().outcome.to_list() == [stored.data["configurations"][0]["outcome"]]


def test_a_folder_of_a_call_is_continued_by_its_repetition(frames, tmp_path, monkeypatch):
    campaign = Campaign.from_frames(frames, validate=["c"], measured=False)

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("haptid.identification.job.identify._combine", stop)
        with pytest.raises(KeyboardInterrupt):
            campaign.identify(folder=tmp_path, kind=None, options=QUICK, fmus=False)
    fitted: list[object] = []
    monkeypatch.setattr("haptid.identification.sequence.sequence.fit_runs", lambda *a, **_: fitted.append(a))
    again = campaign.identify(folder=tmp_path, kind=None, options=QUICK, fmus=False)
    assert fitted == []
    assert again.data["complete"]
    assert (tmp_path / "report.html").is_file()


def test_a_list_of_frames_gets_names_and_a_held_out_part(frames):
    campaign = Campaign.from_frames(list(frames.values()), measured=False)
    assert {run.file for run in campaign.runs} == {"run0", "run1", "run2"}
    assert [run.use for run in campaign.runs].count("validate") == 1


def test_what_is_known_of_a_joint_is_that_of_a_campaign_file(frames):
    known = {0: {"friction": "dahl", "parameters": {"inertia": {"initial": 2e-2, "lower": 1e-3, "upper": 1.0}}}}
    campaign = Campaign.from_frames(frames, joints=known)
    assert campaign.values.friction == {0: "dahl"}
    assert campaign.values.parameter_overrides[0]["inertia"]["initial"] == 2e-2


TIME = np.arange(0.0, 4.0, 0.01)
SIGNALS = {
    "position_0_rad": 0.3 * np.sin(3 * TIME) + 1e-4 * np.random.default_rng(0).standard_normal(TIME.size),
    "voltage_0_V": 2.0 * np.cos(3 * TIME),
    "current_0_A": 0.5 * np.cos(3 * TIME),
    "duty_0": 0.2 * np.cos(3 * TIME),
    "supply_V": 7.4 + 0.1 * np.sin(TIME),
    "reference_0_rad": 0.4 * np.sin(3 * TIME),
}
MOTOR = {"torque_constant": {"initial": 0.4, "lower": 0.05, "upper": 3.0}}
WINDING = {"resistance_ohm": {"initial": 3.0, "lower": 1.0, "upper": 10.0}}


def driven_frame(names: str, scale: float = 1.0) -> pd.DataFrame:
    columns = {name: SIGNALS[name] for name in ("position_0_rad", *names.split())}
    varied = {name: values if name == "supply_V" else scale * values for name, values in columns.items()}
    return pd.DataFrame({"time_s": TIME, **varied})


@pytest.mark.parametrize(
    ("columns", "joint", "inputs"),
    [
        ("voltage_0_V", {"drive": {"kind": "voltage"}}, ("voltage", "enabled")),
        ("voltage_0_V", {"drive": {"kind": "voltage", **MOTOR, **WINDING}, "friction": "dahl"}, ("voltage", "enabled")),
        ("duty_0 supply_V", {"drive": {"kind": "duty", **MOTOR, **WINDING}}, ("duty", "supply", "enabled")),
        ("current_0_A", {"drive": {"kind": "current", **MOTOR}}, ("current", "enabled")),
        (
            "reference_0_rad supply_V",
            {"drive": {"kind": "duty", **MOTOR, **WINDING}, "controller": {"kind": "p", "gain": 0.5, "limit": 0.1}},
            ("reference", "supply", "enabled", "controller_gain"),
        ),
    ],
    ids=["voltage", "voltage and friction", "duty", "current", "closed loop"],
)
def test_a_driven_joint_of_frames_is_that_of_files(columns, joint, inputs, tmp_path):
    tables = {"a": driven_frame(columns), "b": driven_frame(columns, 0.7)}
    here = Campaign.from_frames(tables, validate=["b"], joints={0: joint}, measured=False)
    for name, table in tables.items():
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    runs = [{"file": f"{name}.csv", "free_joints": [0], "use": use} for name, use in (("a", "fit"), ("b", "validate"))]
    head = {"title": "x", "device": "single_joint", "measured": False, "hold": "zero"}
    content = {"campaign": head, "joint": {"0": joint}, "runs": runs}
    (tmp_path / "campaign.toml").write_text(tomli_w.dumps(content))
    there = Campaign.read(tmp_path)
    assert here.values.drives == there.values.drives
    assert here.values.parameter_overrides == there.values.parameter_overrides
    for one, other in zip(here.runs, there.runs, strict=True):
        assert tuple(one.drive_inputs) == tuple(other.drive_inputs) == inputs
        assert np.array_equal(one.inputs, other.inputs)
        assert np.array_equal(one.u, other.u)


@pytest.mark.parametrize(
    ("named", "columns"),
    [("Voltage (mV)", "voltage_0_V"), ("Duty (%)", "duty_0 supply_V")],
)
def test_columns_of_a_voltage_or_a_duty_are_a_drive(named, columns):
    quantity = columns.split()[0]
    frame = driven_frame(columns).rename(columns={quantity: named})
    frame[named] *= {"Voltage (mV)": 1e3, "Duty (%)": 1e2}[named]
    known = {0: {"friction": "dahl", "drive": {"torque_constant": 0.4}}}  # the kind is told by the column
    campaign = Campaign.from_frames({"a": frame}, joints=known)
    kind = quantity.split("_")[0]
    assert campaign.values.drives[0].kind == kind
    assert campaign.values.friction == {0: "dahl"}
    assert np.allclose(np.concatenate([run.drive_inputs[kind] for run in campaign.runs])[:50], SIGNALS[quantity][:50])


@pytest.mark.parametrize("given", ["freedom6s", "freedom6s.toml", "device"])
def test_a_device_by_name_by_path_or_as_it_is(given, tmp_path, monkeypatch):
    built_in = ROOT / "model" / "device" / "built_in" / "freedom6s.toml"
    (tmp_path / "freedom6s.toml").write_bytes(built_in.read_bytes())
    monkeypatch.chdir(tmp_path)
    device = load_device("freedom6s") if given == "device" else given
    campaign = Campaign.from_frames({"a": frame_of(1, joint=4), "b": frame_of(2, joint=4)}, device=device)
    assert campaign.joints == (4,)
    assert campaign.runs[0].posture.shape == (6,)
    assert campaign.values.device == ("freedom6s (given as a Device)" if given == "device" else given)


def without(frames, column: str) -> dict[str, pd.DataFrame]:
    return {**frames, "b": frames["b"].drop(columns=column)}


def with_cell(frames, column: str, value: object) -> dict[str, pd.DataFrame]:
    changed = frames["b"].astype(object)
    changed.loc[6, column] = value
    return {**frames, "b": changed}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda f: with_cell(f, "Angle 0 (deg)", np.nan), "frames/b, row 7, Angle 0 (deg): expected a finite number"),
        (lambda f: with_cell(f, "Torque 0 (Nmm)", "x"), "frames/b, row 7, Torque 0 (Nmm): expected a finite number"),
        (lambda f: with_cell(f, "t (ms)", -5.0), "frames/b, row 7, time_s: expected time that increases"),
        (lambda f: without(f, "Torque 0 (Nmm)"), "frames/b: expected columns time_s, torque_<j>_Nm, position_<j>_rad"),
        (lambda f: {**f, "b": f["b"].iloc[:5]}, "frames/b: expected at least 8 rows, got 5"),
        (lambda f: {**f, "b": [1, 2]}, "frames/b: expected a pandas DataFrame, got list"),
        (lambda f: {**f, "x/y": f["b"]}, "frames: expected names of runs without slashes, got 'x/y'"),
        (lambda f: {3: f["b"]}, 'frames: expected texts as names of runs, got 3; write "3"'),
        (
            lambda f: {**f, "b": pd.concat([f["b"], f["b"]], axis=1)},
            "frames/b: expected one column t (ms), got several",
        ),
    ],
)
def test_a_fault_names_run_row_and_column(frames, change, told):
    with pytest.raises(InputError) as caught:
        Campaign.from_frames(change(frames))
    assert str(caught.value).startswith(told)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"validate": ["d*"]}, "validate: expected one of a, b, c, got d*"),
        ({"device": "freedom6"}, "device: expected a built-in device or a file"),
        ({"device": "no_such.toml"}, "device: expected a file"),
        ({"columns": {"M": "torque"}}, "columns: expected COLUMN=NAME"),
        ({"joints": {0: {"frction": "dahl"}}}, "frames, joint.0.frction: expected"),
        ({"hold": "cubic"}, "frames, campaign.hold: expected"),
        (
            {"validate": [2]},
            "validate: expected names of runs, or patterns such as 'val_*', got 2; the runs are 'a', 'b', 'c'",
        ),
        ({"validate": 2}, "validate: expected names of runs, or patterns such as 'val_*', got 2; the runs are"),
        (
            {"joints": [{"friction": "dahl"}]},
            "joints: expected mappings by number of the joint, got [{'friction': 'dahl'}]; "
            'write joints={0: {"friction": "dahl"}}',
        ),
        ({"joints": {0: "dahl"}}, "joints: expected mappings by number of the joint, got {0: 'dahl'}; write joints="),
        ({"joints": {"elbow": {}}}, "joints: expected mappings by number of the joint, got {'elbow': {}}"),
        ({"joints": {0: {"drive": "voltage"}}}, "frames, joint.0.drive: expected a table with kind, got 'voltage'"),
        ({"columns": ["M"]}, """columns: expected a mapping, got ['M']; write columns={"M": "torque_0_Nm"}"""),
        ({"free": "elbow"}, "free: expected a number of a joint, or several as in (0, 1), got 'elbow'"),
        ({"noise": "1e-4"}, "noise: expected a number in rad (m of a slide), got '1e-4'"),
        ({"noise": 0}, "frames, sensor.noise_rad: expected a positive number"),
        ({"resolution": "x"}, "resolution: expected a number in rad (m of a slide), got 'x'"),
    ],
)
def test_a_wrong_argument_is_named(frames, arguments, told):
    with pytest.raises(InputError) as caught:
        Campaign.from_frames(frames, **arguments)
    assert str(caught.value).startswith(told)
    assert "--" not in str(caught.value)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (
            lambda c: c.find_missing("elbow"),
            "joint: expected a number of a joint, or several as in (0, 1), got 'elbow'",
        ),
        (lambda c: c.find_missing(["elbow"]), "joint: expected a number of a joint"),
        (lambda c: c.find_missing(0.5), "joint: expected a number of a joint"),
        (lambda c: c.find_missing(np.int64(3)), "joint: expected one of the joints 0, got 3"),
        (lambda c: c.find_missing(kind="foo"), "kind: expected one of python, native, native3, got 'foo'"),
        (lambda c: c.identify(joints="elbow"), "joints: expected a number of a joint"),
        (lambda c: c.identify(joints=7), "joints: expected"),
        (lambda c: c.identify(7), "joints: expected joints with runs to fit (0), got 7"),
        (lambda c: c.posterior(7), "joints: expected joints with runs to fit (0), got 7"),
        (lambda c: c.posterior("elbow"), "joints: expected a number of a joint"),
        (lambda c: c.identify(kind="foo"), "kind: expected one of python, native, native3, got 'foo'"),
    ],
)
def test_a_wrong_joint_or_kind_is_named_before_any_work(frames, call, told):
    """A text was taken for its letters, each a joint, and an unknown kind ended in a KeyError."""
    with pytest.raises(InputError) as caught:
        call(Campaign.from_frames(frames))
    assert str(caught.value).startswith(told)
    assert "\n" not in str(caught.value)


def test_a_folder_of_tables_names_the_command_that_an_installation_has(tmp_path):
    (tmp_path / "a.csv").write_text("time_s\n")
    with pytest.raises(InputError, match=r"; make it with haptid init .* --out NEW_FOLDER$"):
        Campaign.read(tmp_path)


def test_positions_that_wrap_are_counted_on_and_told(frames):
    wrapped = {
        name: frame.assign(**{"Angle 0 (deg)": frame["Angle 0 (deg)"] % 360.0}) for name, frame in frames.items()
    }
    with pytest.warns(CampaignWarning, match=r"^a, b and c: position_0_rad counted on where it wraps"):
        campaign = Campaign.from_frames(wrapped, validate=["c"])
    plain = Campaign.from_frames(frames, validate=["c"])
    assert "a, b and c: position_0_rad counted on where it wraps by 6.283 rad" in campaign.remarks
    assert campaign.summary().travel_rad.to_numpy() == pytest.approx(plain.summary().travel_rad.to_numpy())


def test_a_run_with_lost_rows_is_cut_and_told(frames):
    lost = {**frames, "b": frames["b"].drop(index=range(100, 130))}
    with pytest.warns(CampaignWarning, match=r"^b_1: cut where rows are missing, into 2 runs"):
        campaign = Campaign.from_frames(lost, validate=["c"])
    assert [run.file for run in campaign.runs] == ["a", "b_1", "b_2", "c"]
    assert "b_1: cut where rows are missing, into 2 runs" in campaign.remarks
    with pytest.warns(CampaignWarning, match="cut where"):
        kept = Campaign.from_frames(lost, validate=["b"])
    assert [run.file for run in kept.runs if run.use == "validate"] == ["b_1", "b_2"]


def test_a_run_of_few_rows_is_remarked(frames):
    campaign = Campaign.from_frames({"a": frames["a"].iloc[:20], "b": frames["b"], "c": frames["c"]}, validate=["c"])
    (remark,) = [remark for remark in campaign.remarks if "rows" in remark]
    assert remark.startswith("a, joint 0: only 20 rows, 0.038 s: fewer than 50 do not show the noise")


@pytest.mark.parametrize("unit", ["datetime64[ns]", "timedelta64[ns]"])
def test_a_time_of_pandas_is_seconds_from_the_first_row(frames, unit):
    start = 1.7e12 if unit.startswith("datetime") else 0.0
    timed = {name: frame.rename(columns={"t (ms)": "time"}) for name, frame in frames.items()}
    timed = {
        name: frame.assign(time=((start + frame["time"]) * 1e6).round().astype("int64").astype(unit))
        for name, frame in timed.items()
    }
    campaign = Campaign.from_frames(timed, validate=["c"])
    for run, other in zip(campaign.runs, Campaign.from_frames(frames, validate=["c"]).runs, strict=True):
        assert run.t == pytest.approx(other.t, abs=1e-6)


@pytest.mark.parametrize(
    "form",
    [
        lambda at, k: at.tz_convert("Europe/Berlin" if k % 2 else "America/New_York"),
        lambda at, k: at.tz_convert("Europe/Berlin" if k % 2 else "America/New_York").isoformat(),
        lambda at, k: at.to_pydatetime().astimezone(timezone(timedelta(hours=k % 3))),
        lambda at, _k: at.tz_localize(None).to_datetime64(),
        lambda at, _k: (at - pd.Timestamp(0, tz="UTC")).to_pytimedelta(),
    ],
    ids=["zones", "texts", "datetime", "datetime64", "timedelta"],
)
def test_moments_as_objects_are_seconds_from_the_first_row(frames, form):
    """Of several time zones pandas makes a column of objects: its dates were refused, with advice on a command."""
    table = frames["a"].rename(columns={"t (ms)": "time"})
    start = pd.Timestamp("2026-03-29T00:59:58", tz="UTC")  # Berlin changes its clocks two seconds later
    at = [form(start + pd.Timedelta(ms, unit="ms"), k) for k, ms in enumerate(table["time"])]
    campaign = Campaign.from_frames({"a": table.assign(time=pd.Series(at, dtype=object))})
    for run, other in zip(campaign.runs, Campaign.from_frames({"a": frames["a"]}).runs, strict=True):
        assert run.t == pytest.approx(other.t, abs=1e-6)


def test_a_date_that_is_no_time_is_told_what_a_program_does(frames):
    stamp = pd.Timestamp("2026-03-29T00:59:58", tz="UTC")
    table = frames["a"].rename(columns={"t (ms)": "time_s"}).assign(time_s=lambda table: table["time_s"] / 1e3)
    dated = table.assign(**{"Angle 0 (deg)": pd.Series([stamp] * len(table), dtype=object)})
    with pytest.raises(InputError) as caught:
        Campaign.from_frames({"a": dated})
    assert str(caught.value).endswith("; of dates, those of one column, the time, are read: leave one such column, "
                                      "or write a number here")  # fmt: skip
    times = [f"2026-03-29T00:59:58.{k:06d}" for k in range(len(table))]
    times[5] = "2026-13-45T00:59:58"
    with pytest.raises(InputError, match=r"row 6, time_s: expected a finite number, got '2026-13-45.*'; correct the"):
        Campaign.from_frames({"a": table.assign(time_s=times)})


def test_a_time_without_unit_in_milliseconds_is_told(frames):
    with pytest.warns(CampaignWarning, match=r"^a: column 't' is taken for milliseconds, as it has no unit"):
        campaign = Campaign.from_frames({"a": frames["a"].rename(columns={"t (ms)": "t"})})
    assert campaign.runs[0].t == pytest.approx(Campaign.from_frames({"a": frames["a"]}).runs[0].t, abs=1e-12)


def test_a_time_without_unit_is_taken_for_seconds_and_told(frames):
    bare = {"a": frames["a"].assign(**{"t (ms)": frames["a"]["t (ms)"] / 1e3}).rename(columns={"t (ms)": "t"})}
    with pytest.warns(CampaignWarning, match=r"^a: column 't' is taken for seconds, as it has no unit"):
        campaign = Campaign.from_frames(bare)
    assert campaign.remarks[0].startswith("a: column 't' is taken for seconds")


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (
            {"Angle 0 (deg)": "Angle"},
            'no position: use columns={"Angle": "position_0_rad"} (radians; degrees: position_0_rad*0.0174533)',
        ),
        (
            {"Angle 0 (deg)": "Angle", "Torque 0 (Nmm)": "M"},
            'use columns={"M": "torque_0_Nm", "Angle": "position_0_rad"} (radians; degrees: position_0_rad*0.0174533)',
        ),
        ({"t (ms)": "When"}, 'no time: name a column, as in columns={"When": "time_s"}'),
        (
            {"Torque 0 (Nmm)": "Torque (dyn cm)"},
            """use columns={"Torque (dyn cm)": "torque_0_Nm*FACTOR"} (FACTOR: Nm of one 'dyn cm')""",
        ),
        ({"Torque 0 (Nmm)": "Torque 1 (Nmm)"}, "torques of 1, positions of 0; give both one number by columns="),
    ],
)
def test_what_lacks_is_shown_as_python_with_a_column_of_the_table(frames, names, told):
    with pytest.raises(InputError) as caught:
        Campaign.from_frames({"a": frames["a"].rename(columns=names)})
    assert str(caught.value).endswith(told)


def in_steps_of(frame: pd.DataFrame, interval: float) -> pd.DataFrame:
    """Return a table with a time without unit whose rows are so far apart."""
    table = frame.rename(columns={"t (ms)": "t"})
    return table.assign(t=table["t"] * interval / np.median(np.diff(table["t"])))


@pytest.mark.parametrize(("interval", "unit"), [(2.0, "milli"), (2e3, "micro"), (2e6, "nano")])
def test_the_unit_of_a_bare_time_is_the_only_one_of_its_rows_interval(frames, interval, unit):
    with pytest.warns(CampaignWarning, match=f"^a: column 't' is taken for {unit}seconds, as it has no unit"):
        campaign = Campaign.from_frames({"a": in_steps_of(frames["a"], interval)})
    assert np.median(np.diff(campaign.runs[0].t)) == pytest.approx(2e-3)


@pytest.mark.parametrize(
    ("interval", "told"),
    [(0.2, '"time_s"} (s; ms: time_s*0.001)'), (400.0, '"time_s*0.001"} (ms; us: time_s*1e-06)')],
)
def test_a_bare_time_that_may_be_in_two_units_is_asked_for(frames, interval, told):
    """Microseconds were told to be milliseconds."""
    table = in_steps_of(frames["a"], interval)
    with pytest.raises(InputError) as caught:
        Campaign.from_frames({"a": table})
    assert str(caught.value).endswith(f'no time: use columns={{"t": {told}')


def test_a_time_too_coarse_for_seconds_names_its_unit(frames):
    slow = frames["a"].rename(columns={"t (ms)": "time_s"}).assign(time_s=lambda table: 1e3 * table["time_s"])
    with pytest.raises(InputError, match=r"where the time is in us, multiply it by 1e-06$"):
        Campaign.from_frames({"a": slow})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda f: f.assign(M=f["M"].where(f.index != 7)),
            ", row 8, torque_0_Nm: .*; leave such rows out, as by df.dropna",
        ),
        (lambda f: f.assign(M=np.nan), ", row 1, torque_0_Nm: .*; no row has a number there: leave the run out"),
        (lambda f: f.iloc[[*range(50), *range(49, 90)]], r', row 51, time_s: .*; .* df.drop_duplicates\("time_s"\)'),
        (
            lambda f: f.assign(time_s=f["time_s"].round(2)),
            ", row 2, time_s: .* rows repeat a time: give it more digits",
        ),
        (
            lambda f: f.iloc[::-1],
            r', row 2, time_s: .*; sort the rows, as by df.sort_values\("time_s"\), or give each run',
        ),
        (lambda f: f.set_index("time_s"), r": expected a column time_s, got .* index; .* by df.reset_index\(\)"),
        (lambda f: f.set_index("time_s").rename_axis(None), r': .* as by df.reset_index\(names="time_s"\)'),
        (
            lambda f: f.set_index(pd.to_timedelta(f["time_s"], unit="s").rename("at")).drop(columns="time_s"),
            r": .* as by df.reset_index\(\)",
        ),
        (lambda f: f.drop(columns="time_s"), ": expected columns time_s, .*; no time: add time_s"),
    ],
)
def test_the_error_of_a_frame_says_what_a_program_does(frames, change, told):
    table = frames["a"].set_axis(["time_s", "M", "Angle (deg)"], axis=1).assign(time_s=lambda f: f["time_s"] / 1e3)
    stated = {"M": "torque_0_Nm"}
    Campaign.from_frames({"a": table}, columns=stated)
    with pytest.raises(InputError, match=f"^frames/a{told}"):
        Campaign.from_frames({"a": change(table)}, columns=stated)


def test_what_the_errors_say_mends_the_frames(frames):
    table = (
        frames["a"].set_axis(["time_s", "torque_0_Nm", "Angle (deg)"], axis=1).assign(time_s=lambda f: f.time_s / 1e3)
    )
    plain = Campaign.from_frames({"a": table}).runs
    index = pd.to_datetime("2026-01-01") + pd.to_timedelta(table["time_s"], unit="s").rename("at")
    for mended in (
        table.iloc[::-1].sort_values("time_s"),
        table.iloc[[*range(50), *range(49, len(table))]].drop_duplicates("time_s"),
        table.set_index("time_s").reset_index(),
        table.set_index("time_s").rename_axis(None).reset_index(names="time_s"),
        table.set_index(index).drop(columns="time_s").reset_index(),
    ):
        for run, other in zip(Campaign.from_frames({"a": mended}).runs, plain, strict=True):
            assert run.t == pytest.approx(other.t, abs=1e-8)
            assert np.array_equal(run.y, other.y)


@pytest.mark.parametrize(
    ("given", "got"), [("frame", "one DataFrame"), ({}, "none"), ([], "none"), (None, "one NoneType")]
)
def test_frames_that_are_no_mapping_and_no_list_are_refused(frames, given, got):
    """The columns of a bare frame were taken for runs."""
    with pytest.raises(InputError) as caught:
        Campaign.from_frames(frames["a"] if isinstance(given, str) else given, validate=["v"])
    expected = "data frames by the name of their run, or a list of them"
    assert str(caught.value) == f'frames: expected {expected}, got {got}; write {{"run": df}}'


def test_unknown_columns_are_kept_with_a_python_warning(frames):
    strange = {**frames, "a": frames["a"].assign(mood=1.0)}
    with pytest.warns(CampaignWarning, match="columns that the format does not know are kept and not used: mood"):
        campaign = Campaign.from_frames(strange)
    assert "mood" in campaign.runs[0].extra


def test_a_posterior_without_its_extra_names_the_extra(frames, monkeypatch):
    monkeypatch.setattr(extras, "_lacking", lambda _: "arviz")
    with pytest.raises(
        InputError, match=r"^posterior: expected an environment with the extra 'posterior', got no arviz"
    ):
        Campaign.from_frames(frames).posterior()


@pytest.mark.parametrize("workers", [0, -1, 1.5, "2", True])
@pytest.mark.parametrize("call", ["identify", "posterior", "find_missing"])
def test_workers_that_are_none_are_refused(frames, call, workers):
    with pytest.raises(InputError, match=r"^workers: expected a whole number from 1 on, got "):
        getattr(Campaign.from_frames(frames), call)(workers=workers)


def test_workers_of_a_call_go_before_those_of_its_options(frames, monkeypatch):
    asked: list[int] = []

    def stop(job: Job, *_: object) -> None:
        asked.append(job.options.workers)
        raise KeyboardInterrupt

    monkeypatch.setattr("haptid.api.identify.identify", stop)
    for workers in (None, 3):
        with pytest.raises(KeyboardInterrupt):
            Campaign.from_frames(frames).identify(options=QUICK.but(workers=2), workers=workers)
    assert asked == [2, 3]


def test_a_folder_in_use_is_refused(frames, tmp_path):
    from haptid.support.files.folder_lock import lock_folder  # noqa: PLC0415 # only here

    with lock_folder(tmp_path), pytest.raises(InputError, match="one command at a time") as caught:
        Campaign.from_frames(frames).identify(folder=tmp_path)
    assert "name another folder with folder=" in str(caught.value)


def test_public_names_are_imported_when_they_are_asked_for():
    script = "\n".join((
        "import sys, haptid",
        "print('numpy' in sys.modules)",
        "from haptid import InputError",
        "print('pandas' in sys.modules)",
    ))  # fmt: skip
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
    assert {"Campaign", "Identified", "Posteriors", "Missing"} <= set(dir(haptid))
    with pytest.raises(AttributeError, match="no attribute 'campaign_of'"):
        haptid.campaign_of  # noqa: B018 # the look-up is the test


def test_a_current_without_its_torque_is_stated_by_an_argument(frames):
    """Frames have no campaign.toml, to which the error sent the reader."""
    table = frames["a"].set_axis(["time_s", "current_0_A", "position_0_rad"], axis=1)
    table["time_s"] /= 1e3
    with pytest.raises(InputError) as caught:
        Campaign.from_frames({"a": table})
    assert str(caught.value).endswith('got current_0_A; give joints={0: {"torque_constant_Nm_per_A": ...}}')
    with pytest.raises(InputError, match=r'give joints=\{0: \{"force_constant_N_per_A": \.\.\.\}\}$'):
        Campaign.from_frames({"a": table.rename(columns={"position_0_rad": "position_0_m"})})


def test_one_run_that_validates_is_named_without_a_list(frames):
    kept = next(iter(frames))
    uses = {run.file: run.use for run in Campaign.from_frames(frames, validate=kept).runs}
    assert uses.pop(kept) == "validate"
    assert set(uses.values()) == {"fit"}


def test_where_no_run_is_named_a_part_is_held_out(frames):
    """None ended in a TypeError."""
    one, other = (Campaign.from_frames(frames, validate=given) for given in (None, ()))
    assert [run.use for run in one.runs] == [run.use for run in other.runs] == ["fit", "validate", "fit", "fit"]


@pytest.mark.parametrize("noise", [1e-4, np.float32(1e-4)])
def test_a_stated_noise_is_that_of_all_runs(frames, noise):
    campaign = Campaign.from_frames(frames, noise=noise)
    assert {float(run.noise[0]) for run in campaign.runs} == {float(noise)}
    doubtful = Campaign.from_frames(frames, noise=50.0 * noise)
    assert "a noise of 0.005 is stated, the rows show 0.0001: is it in the position's unit?" in doubtful.remarks[0]


def test_results_are_continued_by_the_same_places_of_arguments():
    """A joint without its keyword was a TypeError in one call and none in the other."""
    calls = (
        Campaign.identify, Campaign.posterior, Campaign.find_missing, Identified.posterior, Identified.find_missing
    )  # fmt: skip
    for call in calls:
        first = list(signature(call).parameters.values())[1]
        assert (first.name.rstrip("s"), first.kind) == ("joint", first.POSITIONAL_OR_KEYWORD), call


def test_not_all_runs_may_validate(frames):
    with pytest.raises(InputError, match=r"validate: expected some of the runs, got all of them"):
        Campaign.from_frames(frames, validate=["*"])
