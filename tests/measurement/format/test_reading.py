import gzip
import pickle

import numpy as np
import pandas as pd
import pytest

from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.values.warning import CampaignWarning
from haptid.support.errors import InputError


def test_fields_of_a_campaign(folder):
    campaign = read_campaign(folder.path)
    assert (campaign.title, campaign.device, campaign.label) == ("A test", "single_joint", "synthetic")
    assert campaign.joints == (4,)
    assert campaign.configurations == ((4,),)
    assert campaign.noise_given
    assert campaign.parameter_overrides == {4: {"inertia": {"initial": 2.2e-4, "lower": 2e-5, "upper": 2e-3}}}
    (run,) = campaign.runs_of((4,), "fit")
    assert run.file == "a.csv"
    np.testing.assert_array_equal(run.u[:, 0], folder.frame["torque_4_Nm"])
    np.testing.assert_array_equal(run.y[:, 0], folder.frame["position_4_rad"])
    np.testing.assert_allclose(run.sensor_std, np.sqrt(4e-8 + 2.25e-8 / 12))
    assert run.posture.size == 0
    assert run.v is None


def test_campaign_crosses_processes(folder):
    campaign = pickle.loads(pickle.dumps(read_campaign(folder.path)))
    assert campaign.runs[0].u.shape == (40, 1)


@pytest.mark.parametrize("suffix", [".csv.gz", ".parquet"])
def test_other_formats_hold_the_same(folder, suffix):
    plain = read_campaign(folder.path).runs[0]
    if suffix == ".parquet":
        folder.frame.to_parquet(folder.path / "a.parquet")
    else:
        (folder.path / "a.csv.gz").write_bytes(gzip.compress((folder.path / "a.csv").read_bytes()))
    folder.replace('"a.csv"', f'"a{suffix}"')
    other = read_campaign(folder.path).runs[0]
    for name in ("t", "u", "y"):
        np.testing.assert_array_equal(getattr(other, name), getattr(plain, name))


def test_time_starts_at_zero_and_the_start_is_kept(folder):
    folder.frame.assign(time_s=folder.frame["time_s"] + 100.0).to_csv(folder.path / "a.csv", index=False)
    run = read_campaign(folder.path).runs[0]
    assert run.t[0] == 0
    assert run.start_time == 100.0


def test_prismatic_joint(folder):
    names = {"torque_4_Nm": "force_4_N", "position_4_rad": "position_4_m"}
    frame = folder.frame.rename(columns=names).assign(velocity_4_m_s=1.5)
    frame.to_csv(folder.path / "a.csv", index=False)
    folder.replace("resolution_rad = 1.5e-4", "noise_m = 1e-5\nresolution_m = 0")
    run = read_campaign(folder.path).runs[0]
    assert run.prismatic == (True,)
    assert run.v is not None
    assert run.noise.tolist() == [1e-5]
    assert run.resolution.tolist() == [0.0]


def test_drive_in_amperes(folder):
    frame = folder.frame.rename(columns={"torque_4_Nm": "current_4_A"})
    frame.to_csv(folder.path / "a.csv", index=False)
    folder.replace("[joint.4.parameters]", "[joint.4]\ntorque_constant_Nm_per_A = 0.05\n[joint.4.parameters]")
    run = read_campaign(folder.path).runs[0]
    np.testing.assert_allclose(run.u[:, 0], 0.05 * folder.frame["torque_4_Nm"], rtol=1e-15)


def test_unknown_columns_are_kept_with_one_warning(folder):
    for name in ("a.csv", "b.csv"):
        folder.frame.assign(temperature=20.5, state="run").to_csv(folder.path / name, index=False)
    with pytest.warns(CampaignWarning, match="temperature, state") as caught:
        run = read_campaign(folder.path).runs[0]
    assert len(caught) == 1
    assert (run.extra["temperature"] == 20.5).all()
    assert np.isnan(run.extra["state"]).all()


def test_known_further_columns_are_kept_silently(folder):
    frame = folder.frame.assign(reference_4_rad=0.1, torque_command_4_Nm=0.2, position_3_rad=0.0)
    frame.to_csv(folder.path / "a.csv", index=False)
    assert set(read_campaign(folder.path).runs[0].extra) == {"reference_4_rad", "torque_command_4_Nm", "position_3_rad"}


def test_blank_lines_at_the_end_are_no_rows(folder):
    path = folder.path / "a.csv"
    path.write_text(path.read_text() + "\n\n")
    assert read_campaign(folder.path).runs[0].t.size == 40


def test_free_joints_come_in_ascending_order_with_their_columns(folder):
    frame = pd.DataFrame({"time_s": np.arange(9.0)})
    for j in (0, 1):
        frame[f"torque_{j}_Nm"] = float(j)
        frame[f"position_{j}_rad"] = 10.0 + j
    frame.to_csv(folder.path / "a.csv", index=False)
    folder.toml.write_text(
        '[campaign]\ndevice = "freedom6s"\nmeasured = true\n'
        '[[runs]]\nfile = "a.csv"\nfree_joints = [1, 0]\nuse = "fit"\n'
    )
    run = read_campaign(folder.path).runs[0]
    assert run.free_joints == (0, 1)
    assert run.u[0].tolist() == [0.0, 1.0]
    assert run.y[0].tolist() == [10.0, 11.0]
    assert run.posture.tolist() == [0.0] * 6
    assert np.isnan(run.noise).all()


def test_sensor_of_one_joint_overrules_the_common_one(folder):
    folder.replace("[joint.4.parameters]", "[joint.4.sensor]\nnoise_rad = 7e-4\n[joint.4.parameters]")
    run = read_campaign(folder.path).runs[0]
    assert run.noise.tolist() == [7e-4]
    assert run.resolution.tolist() == [1.5e-4]


def test_other_tables_are_kept_as_extra(folder):
    folder.replace("[sensor]", '[source]\nlicence = "BSD-3-Clause"\n[sensor]')
    assert read_campaign(folder.path).extra == {"source": {"licence": "BSD-3-Clause"}}


def test_device_file_beside_the_campaign(folder):
    (folder.path / "mine.toml").write_text("title = 'mine'\n")
    folder.replace('"single_joint"', '"mine.toml"')
    assert read_campaign(folder.path).device == str(folder.path / "mine.toml")


def test_a_urdf_without_joints_is_told_as_such(folder):
    (folder.path / "arm.urdf").write_text('<robot name="arm"><link name="base"/></robot>')
    folder.replace('"single_joint"', '"arm.urdf"')
    with pytest.raises(InputError, match=r"arm\.urdf, which has no joint that moves, got"):
        read_campaign(folder.path)


def test_joints_of_a_urdf_are_counted(folder):
    joints = "".join(f'<joint name="j{k}" type="{kind}"/>' for k, kind in enumerate(["revolute", "fixed", "prismatic"]))
    (folder.path / "arm.urdf").write_text(f'<robot name="arm">{joints}</robot>')
    folder.replace('"single_joint"', '"arm.urdf"')
    folder.replace("free_joints = [4]", "free_joints = [2]")
    with pytest.raises(InputError, match=r"line 10, joint\.4: expected a joint of .*arm\.urdf, 0 to 1, got 4"):
        read_campaign(folder.path)


def test_missing_device_file_with_a_built_in_namesake(folder):
    folder.replace('"single_joint"', '"freedom6s.toml"')
    with pytest.warns(CampaignWarning, match="built-in device freedom6s"):
        assert read_campaign(folder.path).device == "freedom6s"


@pytest.mark.real("dvrk_mtm_joint4", "dfki_double_pendulum_a0")
@pytest.mark.parametrize("name", ["dvrk_mtm_joint4", "dfki_double_pendulum_a0"])
@pytest.mark.filterwarnings("ignore::haptid.measurement.values.warning.CampaignWarning")
def test_real_measurements(shared, name):
    campaign = read_campaign(shared / name)
    assert campaign.measured
    assert not campaign.noise_given
    assert campaign.extra["source"]["licence"]
    shapes = {"dvrk_mtm_joint4": [(4885, 1)], "dfki_double_pendulum_a0": [(4997, 2)] * 6}
    assert [run.y.shape for run in campaign.runs] == shapes[name]
    assert all(run.v is not None for run in campaign.runs)


def test_embedded_campaign():
    campaign = read_campaign()
    assert campaign.folder == embedded_campaign("planned")
    assert campaign.device == "freedom6s"
    assert not campaign.measured
    assert campaign.joints == (0, 1, 2, 3, 4, 5)
