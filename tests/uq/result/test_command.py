"""The command on a small campaign of the user's own, and through an FMU."""

import csv
import json
import math
import re
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.fmu_build.accuracy.draws import digest_of
from haptid.fmu_build.building.cached import identification_fmu
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.noise.noise_model import NoiseModel
from haptid.support.errors import InputError, NumericalError
from haptid.uq.density.forward import EachForward, KernelForward, kernel_of
from haptid.uq.result.finite import check_finite, early_word
from haptid.uq.run import main
from tests.uq.uq_cases import FREE, TRUTH, make_density, make_run, truth_eta

RUNS = ((2.5, 1, "fit"), (4.0, 2, "fit"), (3.2, 3, "validate"))


@pytest.fixture(scope="module")
def campaign(tmp_path_factory, equations):
    folder = tmp_path_factory.mktemp("campaign")
    lines = [
        '[campaign]\ntitle = "small"\ndevice = "single_joint"\nmeasured = false',
        "[sensor]\nnoise_rad = 2e-4\nresolution_rad = 0.0",
    ]
    lines.append("[joint.4.parameters]")
    for name, value in TRUTH.items():
        if name in FREE:
            lines.append(f"{name} = {{ initial = {value}, prior = {{ mean = {value}, std = {0.1 * abs(value)} }} }}")
        else:
            lines.append(f"{name} = {{ fixed = {value} }}")
    for omega, seed, use in RUNS:
        run = make_run(equations, omega=omega, seed=seed, s=0.02)
        with (folder / f"run{seed}.csv").open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(["time_s", "torque_4_Nm", "position_4_rad"])
            rows = list(zip(run.t, run.u[:, 0], run.y[:, 0], strict=True))
            writer.writerows(rows[:260])
        lines.append(f'[[runs]]\nfile = "run{seed}.csv"\nfree_joints = [4]\nuse = "{use}"')
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    return folder


@pytest.mark.long
def test_the_command_writes_what_it_promises(campaign, tmp_path):
    result = CliRunner().invoke(main, [str(campaign), "--quick", "--out", str(tmp_path), "--workers", "1", "--quiet"])
    assert result.exit_code == 0, result.output
    assert "cycle to cycle" in result.output
    data = json.loads((tmp_path / "posterior.json").read_text())
    assert data["measured"] is False
    (joint,) = data["joints"]
    for name in FREE:
        found = joint["parameters"][name]
        assert abs(found["mean"] - TRUTH[name]) < 4.5 * found["std"]
        low, high = found["intervals"]["0.95"]
        assert low < found["intervals"]["0.5"][0] < found["median"] < found["intervals"]["0.5"][1] < high
    low, high = joint["parameters"]["cycle_scatter"]["intervals"]["0.95"]
    assert low < 0.02 < 2 * high
    page = (tmp_path / "posterior.html").read_text()
    assert "SYNTHETIC DATA" in page
    assert "http" not in page.replace("http-equiv", "").split("<style>")[1].split("data:image")[0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import arviz  # noqa: PLC0415 # announces its next version at import

        stored = arviz.from_netcdf(tmp_path / "posterior" / "joint4.nc", engine="h5netcdf")
    assert set(stored) >= {"posterior", "prior", "log_likelihood", "observed_data"}
    assert stored.posterior["Ks"].dims == ("chain", "draw")
    assert float(stored.posterior["Ks"].mean()) == pytest.approx(joint["parameters"]["Ks"]["mean"], rel=1e-2)
    rows = [line.split(",") for line in (tmp_path / "parameters_posterior.csv").read_text().splitlines()]
    assert "joint4.spring.Ks" in rows[0]
    assert len(rows) == 501
    assert data["draws"] == digest_of((tmp_path / "parameters_posterior.csv").read_bytes())
    assert len(joint["data"]) == 16
    assert set(joint["correlation"]["ids"]) == set(FREE)
    matrix = np.array(joint["correlation"]["matrix"])
    drawn = np.array([[float(x) for x in row] for row in rows[1:]])
    places = [next(k for k, name in enumerate(rows[0]) if name.endswith(id)) for id in joint["correlation"]["ids"]]
    np.testing.assert_allclose(np.corrcoef(drawn[:, places].T), matrix, atol=4.5 / np.sqrt(500))
    again = CliRunner().invoke(main, [str(campaign), "--quick", "--out", str(tmp_path), "--workers", "1", "--quiet"])
    assert again.exit_code == 0
    repeated = json.loads((tmp_path / "posterior.json").read_text())["joints"][0]
    assert repeated["parameters"] == joint["parameters"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["--joints", "2"], "--joints"), (["--joints", "x"], "joint numbers"), (["--seed", "x"], "seed")],
)
def test_bad_input_ends_with_2_and_one_line(campaign, tmp_path, arguments, words):
    result = CliRunner().invoke(main, [str(campaign), *arguments, "--out", str(tmp_path / "none"), "--quiet"])
    assert result.exit_code == 2
    assert words in result.output
    assert not (tmp_path / "none").exists()


def test_missing_campaign_ends_with_2(tmp_path):
    result = CliRunner().invoke(main, [str(tmp_path / "nothing"), "--quiet"])
    assert result.exit_code == 2
    assert "nothing" in result.output


@pytest.mark.parametrize("kind", ["python", "native"])
def test_the_fmu_gives_the_kernel_s_posterior(kind, equations, runs):
    density = make_density(NoiseModel(scatter="reading"), runs[:2], equations)
    rng = np.random.default_rng(0)
    eta = truth_eta(density) + 1e-3 * rng.standard_normal((3, density.coordinates.size))
    fmu = FmuSimulator.of(identification_fmu(equations, kind=kind), equations)
    step = kernel_of(equations).step
    here = density.but(forward=KernelForward(equations=equations, step=step))(eta)
    there = density.but(forward=EachForward(simulator=fmu))(eta)
    np.testing.assert_allclose(there, here, rtol=1e-9, atol=1e-6)


def test_few_rows_are_said_before_any_work(equations, runs):
    short = runs[0].but(t=runs[0].t[:60], u=runs[0].u[:60], y=runs[0].y[:60])
    with_rows = equations.with_parameters({q.id: {"fixed": q.id == "Kp"} for q in equations.parameters})
    assert early_word(with_rows, [short], 4, Path("c")).startswith("joint 4: 60 rows to fit for 11 free parameters")
    assert early_word(equations, runs, 4, Path("c")) == ""
    fixed = equations.with_parameters({q.id: {"fixed": True} for q in equations.parameters})
    with pytest.raises(InputError, match=r"^c/campaign.toml, joint.4.parameters: expected .* wanted, got all fixed"):
        early_word(fixed, runs, 4, Path("c"))


def test_a_posterior_without_numbers_ends_in_words():
    interval = {0.95: (math.nan, 1.0)}
    lost, sound = (SimpleNamespace(id=id, mean=0.0, std=1.0, median=0.0, intervals=i) for id, i in
                   (("vs", interval), ("Ks", {0.95: (0.0, 1.0)})))  # fmt: skip
    with pytest.raises(
        NumericalError, match="joint 3: the posterior of vs is not finite: the runs do not determine it"
    ):
        check_finite(SimpleNamespace(joint=3, parameters=(sound, lost)))
    assert check_finite(SimpleNamespace(joint=3, parameters=(sound,))).joint == 3


def write_runs_that_determine_nothing(folder, shape):
    """Write a position that is the torque, or one that grows evenly whatever the torque does."""
    t = np.arange(400) * 0.005
    rng = np.random.default_rng(0)
    lines = ['[campaign]\ndevice = "single_joint"\nmeasured = false']
    for k, use in enumerate(("fit", "validate")):
        torque = 1e-2 * np.cos(2 * np.pi * (1 + k) * t)
        y = (
            torque + 1e-7 * rng.standard_normal(t.size)
            if shape == "torque"
            else 0.5 * t + 1e-5 * rng.standard_normal(t.size)
        )
        rows = np.column_stack((t, torque, y))
        header = "time_s,torque_0_Nm,position_0_rad"
        np.savetxt(folder / f"{k}.csv", rows, delimiter=",", header=header, comments="")
        lines.append(f'[[runs]]\nfile = "{k}.csv"\nfree_joints = [0]\nuse = "{use}"')
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    return [str(folder), "--quick", "--out", str(folder / "out"), "--workers", "1", "--quiet"]


@pytest.mark.long
def test_runs_that_determine_nothing_end_in_words(tmp_path):
    result = CliRunner().invoke(main, write_runs_that_determine_nothing(tmp_path, "torque"))
    if result.exit_code == 0:
        # Which minimum far above the noise a fit ends in decides whether the density has a curvature there.
        assert "do not use these intervals yet" in result.output
        assert re.search(r"The model leaves \d{2,} times the noise", result.output)
    else:
        assert result.exit_code == 1
        assert "the runs do not determine" in result.output
        assert result.output.count("\n") == 1
        assert not (tmp_path / "out" / "posterior.json").exists()


@pytest.mark.long
def test_a_motion_that_ignores_the_torque_ends_in_words_or_in_numbers_with_what_is_open(tmp_path):
    result = CliRunner().invoke(main, write_runs_that_determine_nothing(tmp_path, "line"))
    if result.exit_code == 0:
        (joint,) = json.loads((tmp_path / "out" / "posterior.json").read_text())["joints"]
        assert all(math.isfinite(one[key]) for one in joint["parameters"].values() for key in ("mean", "std"))
        # Ranges of first guesses are widened until the model follows any motion; the notes say which of them are ends.
        assert any("inertia" in note and "the runs leave it open" in note for note in joint["notes"])
    else:
        assert result.exit_code == 1
        assert "hardly any point" in result.output
        assert not (tmp_path / "out" / "posterior.json").exists()
