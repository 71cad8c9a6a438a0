import numpy as np

from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.signals.hold_out import hold_out, with_validation


def test_last_third_in_time_is_held_out(folder):
    run = read_campaign(folder.path).runs[0]
    fit, validate = hold_out(run)
    assert fit.use == "fit"
    assert validate.use == "validate"
    assert fit.t.size == validate.score_from
    np.testing.assert_array_equal(validate.t, run.t)
    np.testing.assert_array_equal(fit.u, run.u[: fit.t.size])
    assert fit.t[-1] < 2 / 3 * run.t[-1] <= validate.t[validate.scored][0]
    assert "last third was held out" in validate.notes[0]


def test_split_of_uneven_rows_is_in_time_not_in_rows(folder):
    run = read_campaign(folder.path).runs[0]
    uneven = run.but(t=np.linspace(0, 1, run.t.size) ** 3)
    fit, _ = hold_out(uneven)
    assert fit.t.size > 0.8 * run.t.size


def test_only_configurations_without_validation_run_are_split(folder):
    campaign = read_campaign(folder.path)
    assert with_validation(campaign) is not campaign
    assert [run.file for run in with_validation(campaign).runs] == ["a.csv", "b.csv"]


def test_longest_fit_run_is_split_in_place(folder):
    folder.replace('use = "validate"', 'use = "fit"')
    frame = folder.frame.assign(time_s=2 * folder.frame["time_s"])
    frame.to_csv(folder.path / "b.csv", index=False)
    runs = with_validation(read_campaign(folder.path)).runs
    assert [(run.file, run.use) for run in runs] == [("a.csv", "fit"), ("b.csv", "fit"), ("b.csv", "validate")]


def test_short_run_is_left_whole_with_a_note(folder):
    folder.replace('use = "validate"', 'use = "excluded"\nreason = "short"')
    folder.frame.iloc[:20].to_csv(folder.path / "a.csv", index=False)
    campaign = with_validation(read_campaign(folder.path))
    assert campaign.runs_of((4,), "validate") == ()
    assert "too short" in campaign.runs[0].notes[0]


def test_prepared_campaign_lacks_nothing(folder):
    folder.replace("noise_rad = 2e-4\nresolution_rad = 1.5e-4\n", "")
    folder.replace('use = "validate"', 'use = "fit"')
    campaign = prepare(read_campaign(folder.path))
    assert not campaign.noise_given
    assert all(np.isfinite(run.sensor_std).all() and (run.sensor_std > 0).all() for run in campaign.runs)
    assert campaign.runs_of((4,), "validate")
