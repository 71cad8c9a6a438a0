"""Every fault ends in one InputError of one line that names file, line or key, expected and got."""

import gzip
import re

import pytest

from haptid.measurement.format.places import outside_allowed
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.values.warning import CampaignWarning
from haptid.support.errors import InputError


def fault(folder, pattern: str) -> InputError:
    with pytest.raises(InputError) as caught:
        read_campaign(folder.path)
    text = str(caught.value)
    assert re.search(pattern, text), text
    assert "\n" not in text
    assert caught.value.exit_code == 2
    assert str(folder.path) in text
    return caught.value


TOML_FAULTS = [
    ("measured = false", "measured = false false", r"campaign\.toml, line 4: expected valid TOML"),
    ('use = "validate"\n', 'use = "valid', r"campaign\.toml, line 21: expected valid TOML"),
    ("free_joints = [4]", "fee_joints = [4]", r"line 15, runs\[0\]\.fee_joints: .*did you mean free_joints"),
    (
        "free_joints = [4]",
        "free_joints = 4",
        r"line 15, runs\[0\]\.free_joints: expected distinct joint numbers.*got 4",
    ),
    ("free_joints = [4]", "free_joints = [4, 4]", r"line 15, runs\[0\]\.free_joints"),
    ("free_joints = [4]", "free_joints = [-1]", r"line 15, runs\[0\]\.free_joints"),
    ("free_joints = [4]", "free_joints = []", r"line 15, runs\[0\]\.free_joints"),
    ("free_joints = [4]", "free_joints = [true]", r"line 15, runs\[0\]\.free_joints"),
    ("free_joints = [4]", "free_joints = [3, 4]", r"line 15, .*one free joint for single_joint, got \[3, 4\]"),
    ("free_joints = [4]\n", "", r"line 13, runs\[0\]\.free_joints: .*got no such key"),
    ('use = "fit"', 'use = "fitt"', r'line 16, runs\[0\]\.use: expected "fit", "validate" or "excluded", got \'fitt\''),
    ('use = "fit"', 'use = "excluded"', r"line 13, runs\[0\]\.reason: expected a reason .* got none"),
    ('use = "fit"', 'use = "excluded"\nreason = "broken"', r'at least one run with use = "fit"'),
    ("free_joints = [4]", "free_joints = [3]", r"a column torque_3_Nm"),
    ('file = "b.csv"', 'file = "a.csv"', r"line 19, runs\[1\]\.file: expected each table once, got 'a\.csv' again"),
    ('file = "b.csv"', 'file = "c.csv"', r"c\.csv: expected a table of a run, got no such file"),
    ('file = "b.csv"', 'file = "campaign.toml"', r"expected a file that ends in \.csv"),
    ('"single_joint"', '"freedom6"', r"line 3, campaign\.device: .*got 'freedom6'; did you mean freedom6s"),
    ('"single_joint"', '"nowhere.toml"', r"line 3, campaign\.device: .*got no file .*nowhere\.toml"),
    ('device = "single_joint"\n', "", r"campaign\.device: .*got no such key"),
    ("measured = false\n", "", r"campaign\.measured: expected true .*got no such key"),
    ("measured = false", "measured = 0", r"line 4, campaign\.measured: .*got 0"),
    ("measured = false", 'measured = false\nhold = "cubic"', r'line 5, campaign\.hold: expected "zero" or "linear"'),
    ("[campaign]", "[campagne]", r"line 1, campagne: .*did you mean campaign"),
    ("[sensor]", "[sensors]", r"line 6, sensors: .*did you mean sensor"),
    ("noise_rad = 2e-4", "noise_rad = -2e-4", r"line 7, sensor\.noise_rad: expected a positive number"),
    ("noise_rad = 2e-4", "noise_rad = nan", r"line 7, sensor\.noise_rad"),
    ("noise_rad = 2e-4", "noise = 2e-4", r"line 7, sensor\.noise: .*did you mean noise_m or noise_rad"),
    ("inertia =", "inetria =", r"line 11, joint\.4\.parameters\.inetria: .*did you mean inertia"),
    ("initial = 2.2e-4", "initial = 3", r"line 11, joint\.4\.parameters\.inertia: .*got initial 3 outside"),
    ("lower = 2e-5", "lower = 2", r"line 11, .*expected lower < upper"),
    ("initial = 2.2e-4", "inital = 2.2e-4", r"inertia\.inital: .*did you mean initial"),
    ("{ initial = 2.2e-4, lower = 2e-5, upper = 2e-3 }", "2.2e-4", r"inertia: expected a table, got 0\.00022; write"),
    ("[joint.4.parameters]", "[joint.four.parameters]", r"joint\.four: expected a joint number"),
    (
        "[joint.4.parameters]",
        '[joint.4]\nfriction = "Dahl"\n[joint.4.parameters]',
        r"line 11, joint\.4\.friction: expected a friction law \(.*dahl, lugre, .*\), got 'Dahl'",
    ),
    (
        "[joint.4.parameters]",
        '[joint.4]\nfriction = "dahl"\n[joint.4.parameters]\nvs = { initial = 0.1 }',
        r"joint\.4\.parameters\.vs: expected a parameter of a joint, got 'vs'",
    ),
    ("[joint.4.parameters]", "[joint.4.parameters]\nsigma9 = { initial = 1.0 }", r"sigma9: .*did you mean sigma"),
]


@pytest.mark.parametrize(("old", "new", "pattern"), TOML_FAULTS, ids=[f"{k}" for k in range(len(TOML_FAULTS))])
def test_fault_in_campaign_toml(folder, old, new, pattern):
    folder.replace(old, new)
    fault(folder, pattern)


def test_missing_folder(tmp_path):
    with pytest.raises(InputError, match="nowhere: expected the folder of a campaign, got no such folder"):
        read_campaign(tmp_path / "nowhere")


def test_missing_campaign_toml(folder):
    folder.toml.unlink()
    fault(folder, r"campaign\.toml: .*got no such file; make it with haptid init")
    (folder.path / "identification.json").write_text("{}")
    fault(folder, r"got no such file; this folder holds results: name that of the campaign they were made of")


def test_joint_beyond_the_device(folder):
    folder.replace('"single_joint"', '"freedom6s"')
    folder.replace("free_joints = [4]", "free_joints = [6]")
    fault(folder, r"line 15, runs\[0\]\.free_joints: expected joints of freedom6s, 0 to 5, got \[6\]")


def test_posture_of_the_wrong_length(folder):
    folder.replace('"single_joint"', '"freedom6s"')
    folder.replace('use = "fit"', 'use = "fit"\nlocked_positions_rad = [0.0, 1.0]')
    fault(folder, r"line 17, runs\[0\]\.locked_positions_rad: expected 6 numbers.*got 2")


def test_validation_run_of_a_joint_without_fit_run(folder):
    folder.frame.rename(columns=lambda name: name.replace("4", "3")).to_csv(folder.path / "b.csv", index=False)
    text = folder.toml.read_text()
    head, _, tail = text.rpartition("free_joints = [4]")
    folder.toml.write_text(head + "free_joints = [3]" + tail)
    fault(folder, r'line 21, runs\[1\]\.use: expected a run with use = "fit" for joint 3')


TABLE_FAULTS = [
    (1, "time_s,torque_4,position_4_rad", r"a\.csv, line 1: expected a column torque_4_Nm, .*did you mean 'torque_4'"),
    (1, "time_s,torque_4_Nm,angle", r"a\.csv, line 1: expected a column position_4_rad, got none; it has time_s"),
    (
        1,
        "time_s,torque_4_Nm,torque_4_Nm",
        r"line 1: expected each column once, got 2 columns named .torque_4_Nm.; rename",
    ),
    (
        1,
        "time_s,torque_4_Nm,position_4_rad,note, note",
        r"line 1: expected each column once, got 2 columns named 'note'",
    ),
    (7, "0.025,,0.1", r"a\.csv, line 7, torque_4_Nm: expected a finite number, got an empty or NaN cell"),
    (7, "0.025,NaN,0.1", r"a\.csv, line 7, torque_4_Nm: .*NaN"),
    (7, "0.025,inf,0.1", r"a\.csv, line 7, torque_4_Nm: .*got 'inf'"),
    (7, "0.025,0.1,abc", r"a\.csv, line 7, position_4_rad: expected a finite number, got 'abc'"),
    (
        7,
        "0.015,0.1,0.1",
        r"a\.csv, line 7, time_s: .* increases .*got 0\.015 s after 0\.02 s; sort the rows",
    ),
    (7, "0.02,0.1,0.1", r"a\.csv, line 7, time_s: expected time that increases .*got 0\.02 s after 0\.02 s; take such"),
    (7, "", r"a\.csv, line 7, time_s: .*empty"),
]


@pytest.mark.parametrize(("line", "text", "pattern"), TABLE_FAULTS, ids=[f"{k}" for k in range(len(TABLE_FAULTS))])
def test_fault_in_a_table(folder, line, text, pattern):
    folder.line(line, text)
    fault(folder, pattern)


@pytest.mark.parametrize(
    ("renamed", "pattern"),
    [
        (
            {"position_4_rad": "position_4_m"},
            r"a column force_4_N, got torque_4_Nm beside position_4_m; a joint that slides has a force in N: name that",
        ),
        (
            {"torque_4_Nm": "force_4_N"},
            r"a column torque_4_Nm, got force_4_N beside position_4_rad; a joint that turns has a torque in N m: name",
        ),
    ],
)
def test_a_torque_of_a_joint_that_slides_is_no_misnamed_column(folder, renamed, pattern):
    folder.frame.rename(columns=renamed).to_csv(folder.path / "a.csv", index=False)
    fault(folder, pattern)


def test_too_many_cells_in_a_line(folder):
    folder.line(9, "0.035,0.1,0.2,0.3,0.4")
    fault(folder, r"a\.csv, line 9: expected 3 cells, as the header has, got 5; where a comma is the decimal sign")


@pytest.mark.parametrize(
    ("content", "pattern"),
    [
        (b"", r"a\.csv: expected a header and at least 8 rows, got an empty file"),
        (b"time_s,torque_4_Nm,position_4_rad\n", r"a\.csv: expected at least 8 rows, got 0"),
        (b"time_s,torque_4_Nm,position_4_rad\n0,1,2\n1,2,3\n", r"a\.csv: expected at least 8 rows, got 2"),
        (b"time_s;torque_4_Nm;position_4_rad\n" + b"0;1;2\n" * 9, r"columns separated by commas, got semicolons"),
        (b"\xff\xfe\x00\x01\x9a", r"a\.csv, line 1: expected a text in UTF-8, got byte 0xff; save it as UTF-8"),
    ],
)
def test_table_that_is_none(folder, content, pattern):
    (folder.path / "a.csv").write_bytes(content)
    fault(folder, pattern)


@pytest.mark.parametrize("suffix", [".csv.gz", ".parquet"])
def test_broken_archives(folder, suffix):
    (folder.path / f"a{suffix}").write_bytes(b"\x1f\x8b\x08 broken")
    folder.replace('"a.csv"', f'"a{suffix}"')
    fault(folder, rf"a{re.escape(suffix)}: expected a table in")


def test_parquet_rows_are_counted_from_one(folder):
    folder.frame.loc[5, "torque_4_Nm"] = float("nan")
    folder.frame.to_parquet(folder.path / "a.parquet")
    folder.replace('"a.csv"', '"a.parquet"')
    fault(folder, r"a\.parquet, row 6, torque_4_Nm")


def test_current_without_torque_constant(folder):
    folder.frame.rename(columns={"torque_4_Nm": "current_4_A"}).to_csv(folder.path / "a.csv", index=False)
    fault(folder, r"got current_4_A; give torque_constant_Nm_per_A under \[joint\.4\]")


def slide(folder) -> None:
    for name in ("a.csv", "b.csv"):
        table = folder.frame.rename(columns={"torque_4_Nm": "force_4_N", "position_4_rad": "position_4_m"})
        table.to_csv(folder.path / name, index=False)


def test_a_noise_in_the_unit_of_another_motion(folder):
    """It was ignored, and the noise estimated instead."""
    slide(folder)
    fault(folder, r"line 7, sensor\.noise_rad: expected noise_m of joints that slide, got noise_rad; state it in m, as")
    folder.replace("noise_rad = 2e-4", "noise_m = 2e-4")
    fault(folder, r"line 8, sensor\.resolution_rad: expected resolution_m of joints that slide")
    folder.replace("resolution_rad = 1.5e-4", "resolution_rad = 1.5e-4\nresolution_m = 1e-6")
    read_campaign(folder.path)
    folder.replace("[joint.4.parameters]", "[joint.4.sensor]\nnoise_rad = 1e-4\n[joint.4.parameters]")
    fault(folder, r"joint\.4\.sensor\.noise_rad: expected noise_m of joints that slide")


def test_a_noise_in_metres_of_a_joint_that_turns(folder):
    folder.replace("noise_rad = 2e-4", "noise_m = 2e-4")
    fault(
        folder, r"sensor\.noise_m: expected noise_rad of joints that turn, got noise_m; state it in rad, as noise_rad"
    )


def test_position_in_two_units(folder):
    folder.frame.assign(position_4_m=0.0).to_csv(folder.path / "a.csv", index=False)
    fault(folder, r"expected one position of joint 4")


def test_a_packed_table_that_fills_the_memory_is_refused(folder):
    folder.replace('file = "a.csv"', 'file = "a.csv.gz"')
    with gzip.open(folder.path / "a.csv.gz", "wb") as stream:
        stream.write(b"time_s,torque_4_Nm,position_4_rad\n")
        for _ in range(100):
            stream.write(b"0,0,0\n" * 200_000)
    fault(folder, r"a\.csv\.gz: expected a table that unpacks to at most 250 times")


def test_a_damaged_parquet_table_is_refused(folder):
    folder.replace('file = "a.csv"', 'file = "a.parquet"')
    folder.frame.to_parquet(folder.path / "a.parquet")
    content = (folder.path / "a.parquet").read_bytes()
    (folder.path / "a.parquet").write_bytes(content[:200] + b"\xff" * 40 + content[240:])
    fault(folder, r"a\.parquet: expected a table in Parquet, got a damaged file \(\w+\); export it again")


@pytest.mark.parametrize("way", ["dots", "absolute", "link"])
def test_files_outside_the_folder_need_to_be_allowed(folder, tmp_path, way):
    outside = tmp_path / "a.csv"
    (folder.path / "a.csv").rename(outside)
    if way == "link":
        (folder.path / "a.csv").symlink_to(outside)
    else:
        folder.replace('file = "a.csv"', f'file = "{"../a.csv" if way == "dots" else outside}"')
    fault(folder, r"runs\[0\]\.file: expected a file inside the campaign's folder, got .*allow it by --allow-outside")
    with outside_allowed(), pytest.warns(CampaignWarning, match="lies outside the campaign's folder"):
        read_campaign(folder.path)


def test_a_device_file_outside_the_folder_needs_to_be_allowed(folder, tmp_path):
    (tmp_path / "arm.toml").write_text("")
    folder.replace('"single_joint"', '"../arm.toml"')
    fault(folder, r"campaign\.device: expected a file inside the campaign's folder, got .*allow it by --allow-outside")


LATE = [
    (310, "1.54,0,005,0,1", r"line 310: expected 3 cells, as the header has, got 5; where a comma is the decimal sign"),
    (310, '1.54,"0.1,0.1', r"line 310: expected quotes in pairs, got one that nothing closes; close the quote"),
    (310, "1.54,0.1,0.1 \xb5", r"line 310: expected a text in UTF-8, got byte 0xb5; save it as UTF-8"),
    (310, '1.54,"0,05",0.1', r"line 310, torque_4_Nm: .*got '0,05'; where a comma is the decimal sign"),
    (310, "1.54,inf,0.1", r"line 310, torque_4_Nm: expected a finite number, got 'inf'; correct the cell"),
    (310, "1.54,-Infinity,0.1", r"line 310, torque_4_Nm: expected a finite number, got '-Infinity'; correct the cell"),
    (310, f"1.54,{'9' * 400},0.1", r"line 310, torque_4_Nm: .*got '9{20}…9{19}'; no value is above"),
    (310, f"1.54,{'9' * 5000},0.1", r"line 310, torque_4_Nm: .*got '9{20}…9{19}'; no value is above"),
]


@pytest.mark.parametrize(("line", "text", "pattern"), LATE, ids=[f"{k}" for k in range(len(LATE))])
@pytest.mark.parametrize("suffix", [".csv", ".csv.gz"])
def test_faults_far_down_a_table_name_their_line(folder, suffix, line, text, pattern):
    rows = [f"{0.005 * k:.3f},0.1,{0.001 * k:.3f}" for k in range(400)]
    lines = ["time_s,torque_4_Nm,position_4_rad", *rows]
    lines[line - 1] = text
    content = "\n".join(lines).encode("latin-1")
    (folder.path / f"a{suffix}").write_bytes(content if suffix == ".csv" else gzip.compress(content))
    folder.replace('"a.csv"', f'"a{suffix}"')
    fault(folder, rf"a{re.escape(suffix)}, {pattern}")


@pytest.mark.parametrize(
    ("header", "pattern"),
    [
        ("\n\ntime_s,torque_4_Nm,position_4_rad", r"a\.csv, line 1: expected the header, got a blank line"),
        ("time_s torque_4_Nm position_4_rad", r"a\.csv, line 1: expected columns separated by commas, got blanks"),
        ("time_s|torque_4_Nm|position_4_rad", r"a\.csv, line 1: expected columns separated by commas, got bars"),
    ],
)
def test_headers_that_are_laid_out_otherwise(folder, header, pattern):
    folder.line(1, header)
    fault(folder, pattern)


def test_a_folder_in_place_of_a_table(folder):
    (folder.path / "d.csv").mkdir()
    folder.replace('"a.csv"', '"d.csv"')
    assert "did you mean d.csv" not in str(fault(folder, r"d\.csv: expected a table of a run, got a folder"))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_true_and_false_are_no_torque(folder, suffix):
    frame = folder.frame.assign(torque_4_Nm=True)
    frame.to_csv(folder.path / "a.csv", index=False)
    if suffix == ".parquet":
        frame.to_parquet(folder.path / "a.parquet")
        folder.replace('"a.csv"', '"a.parquet"')
    fault(folder, r", torque_4_Nm: expected a finite number, got 'True'")


STATED = "inertia = { initial = 2.2e-4, lower = 2e-5, upper = 2e-3 }"
CONTRADICTIONS = [
    (STATED, "inertia = { fixed = -1.0 }", r"line 11, joint\.4\.parameters\.inertia: expected fixed from .* got -1"),
    (STATED, "inertia = { initial = 0.0 }", r"parameters\.inertia: .*it must be positive"),
    (STATED, "inertia = { upper = -1.0 }", r"parameters\.inertia: "),
    (STATED, "inertia = {}", r"parameters\.inertia: .*empty table"),
    (STATED, "inertia = { initial = 1e-3, fixed = 2e-3 }", r"parameters\.inertia: expected fixed alone"),
    (STATED, "Fs = { fixed = 1e-3 }\nFc = { fixed = 1.0 }", r"line 11, joint\.4\.parameters\.Fs: expected Fs >= Fc"),
    (STATED, "epos = { fixed = 1e300 }", r"parameters\.epos: .*check its unit"),
    (STATED, "Ks = { prior = { mean = 9.0, std = 1.0 }, upper = 2.0 }", r"parameters\.Ks: .*prior's mean within"),
    ("resolution_rad = 1.5e-4", "resolution_rad = 1e300", r"line 8, sensor\.resolution_rad: expected 0, or"),
    ("resolution_rad = 1.5e-4", "resolution_rad = 1e-300", r"line 8, sensor\.resolution_rad: expected 0, or"),
    ("[joint.4.parameters]",
     "[joint.4]\ntorque_constant_Nm_per_A = 1e300\n[joint.4.parameters]", r"_A: .*1e-09 to 1e"),
    ('use = "fit"', 'use = "fit"\nlocked_positions_rad = [1e300]',
     r"line 17, runs\[0\]\.locked_positions_rad: .* none"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "pattern"), CONTRADICTIONS, ids=[f"{k}" for k in range(len(CONTRADICTIONS))])
def test_numbers_that_nothing_can_have(folder, old, new, pattern):
    folder.replace(old, new)
    fault(folder, pattern)


def test_the_table_of_a_joint_without_runs_is_warned_of(folder):
    folder.replace("[joint.4.parameters]", "[joint.7.parameters]")
    with pytest.warns(CampaignWarning, match=r"line 10, joint\.7: no run frees joint 7 \(joints with runs: 4\)"):
        read_campaign(folder.path)


def test_bounds_of_what_stays_fixed_are_warned_of(folder):
    folder.replace("[joint.4.parameters]", "[joint.4.parameters]\nKp = { lower = 0.5, upper = 2.0 }")
    with pytest.warns(CampaignWarning, match=r"Kp stays fixed, .* a prior would free it"):
        read_campaign(folder.path)
