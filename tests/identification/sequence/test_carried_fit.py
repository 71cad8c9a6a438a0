"""The fit of the identification is carried on where, and only where, it belongs to the same data."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from haptid.discrepancy.fit.nominal_fit import fit_nominal
from haptid.discrepancy.study.study import study_of
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.run import main
from haptid.identification.sequence.carried_fit import EarlierResidual, carried_fit, earlier_free_rms, earlier_residual
from haptid.identification.sequence.configurations import configurations_of
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.devices import device_of
from haptid.measurement.format.embedded import embedded_campaign


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """Results of the identification of joint 4 of an embedded campaign, and the campaign."""
    out = tmp_path_factory.mktemp("identified")
    options = ["--campaign", "paper", "--joints", "4", "--fmu", "none", "--workers", "1", "--no-export", "--quiet"]
    result = CliRunner().invoke(main, [*options, "--out", str(out)])
    assert result.exit_code == 0, result.output
    return out, campaign_for_command(embedded_campaign("paper"))


def carried(campaign, out):
    """Return the carried fit of joint 4, None where there is none."""
    device = device_of(campaign)
    configuration = configurations_of(campaign, device, (4,))[0]
    equations = equations_for(campaign, device, (4,), configuration.posture)
    return carried_fit(campaign, device, configuration, equations, out)


def test_the_fit_is_read_as_it_was_written(identified):
    out, campaign = identified
    entry = json.loads((out / "identification.json").read_text())["configurations"][0]
    assert carried(campaign, out).values == {id: one["value"] for id, one in entry["parameters"].items()}


def test_nothing_is_carried_without_results(identified, tmp_path):
    assert carried(identified[1], tmp_path) is None


@pytest.mark.parametrize("change", ["a reading", "an entry of the user", "the use of a run"])
def test_nothing_is_carried_to_other_data(identified, change):
    out, campaign = identified
    place = next(k for k, run in enumerate(campaign.runs) if run.free_joints == (4,))
    run = campaign.runs[place]
    if change == "an entry of the user":
        other = replace(campaign, parameter_overrides={4: {"Fc": {"initial": 1e-3}}})
    else:
        moved = run.but(y=run.y + 1e-9) if change == "a reading" else run.but(use="excluded")
        other = replace(campaign, runs=(*campaign.runs[:place], moved, *campaign.runs[place + 1 :]))
    assert carried(other, out) is None


@pytest.mark.parametrize(
    "change", [{"outcome": "torque_scored"}, {"observer_gain_per_s": 5.0}, {"parameters": {}}, {"free": ["inertia"]}]
)
def test_a_fit_that_was_not_by_free_simulation_or_that_was_changed_is_not_carried(identified, tmp_path, change):
    out, campaign = identified
    data = json.loads((out / "identification.json").read_text())
    data["configurations"][0] |= change
    (tmp_path / "identification.json").write_text(json.dumps(data))
    assert carried(campaign, tmp_path) is None


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, EarlierResidual(at_noise=True, plain=False)),
        ({"residual": "torque"}, EarlierResidual(at_noise=False, plain=False)),
        ({"basins": [{"rmse_over_noise": 3.0}]}, EarlierResidual(at_noise=False, plain=False)),
        ({"basins": [{"rmse_over_noise": 3.0}], "outcome": "plain"}, EarlierResidual(at_noise=False, plain=True)),
        ({"data": "of another run"}, None),
        ({"basins": []}, None),
    ],
)
def test_the_residual_of_the_position_is_carried(identified, tmp_path, change, expected):
    out, campaign = identified
    data = json.loads((out / "identification.json").read_text())
    data["configurations"][0] |= change
    (tmp_path / "identification.json").write_text(json.dumps(data))
    device = device_of(campaign)
    configuration = configurations_of(campaign, device, (4,))[0]
    assert earlier_residual(campaign, device, configuration, tmp_path) == expected


def test_the_nominal_fit_ends_at_the_same_optimum_in_fewer_simulations(identified):
    out, campaign = identified
    study = study_of(campaign, 4, {})
    alone = fit_nominal(study, starts=4)
    begun = fit_nominal(replace(study, carried=carried(campaign, out)), starts=4)
    assert begun.calls < alone.calls / 2
    assert begun.solution.chi2 == pytest.approx(alone.solution.chi2, abs=0.1)
    # Both fits end where a step promises less than this tolerance, so that they may lie apart by as much.
    apart = alone.solution.blocks.jacobian @ (begun.solution.x - alone.solution.x)
    assert apart @ apart < 4 * THRESHOLDS.fit.nominal_tolerance_chi2


def test_how_far_the_better_model_strays_in_free_simulation_is_carried(identified, tmp_path):
    out, campaign = identified
    device = device_of(campaign)
    configuration = configurations_of(campaign, device, (4,))[0]
    data = json.loads((out / "identification.json").read_text())
    runs = data["configurations"][0]["runs"]
    for run in runs:
        run["figures"] = {"model": {"free_rmse": 3.0}, "baseline": {"free_rmse": 2.0}}
        if run["use"] == "fit":
            run["figures"] = {"model": {"free_rmse": 0.1}, "baseline": {"free_rmse": 0.1}}
    (tmp_path / "identification.json").write_text(json.dumps(data))
    assert earlier_free_rms(campaign, device, configuration, tmp_path) == pytest.approx(2.0)
    for run in runs:
        run["figures"]["baseline"]["free_rmse"] = None  # its simulation did not stay finite
    (tmp_path / "identification.json").write_text(json.dumps(data))
    assert earlier_free_rms(campaign, device, configuration, tmp_path) == pytest.approx(3.0)
    assert earlier_free_rms(campaign, device, configuration, tmp_path / "none") is None
