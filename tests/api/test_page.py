"""The page on the Python API: its code runs from top to bottom, and every result of it is what it says."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import fmpy
import matplotlib.image
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from docs.from_code.api_reference import CLASSES, api_page
from docs.from_runs import python_api
from haptid import Campaign, Identified, InputError, Missing, Posteriors
from haptid.fmu_build.native.platforms import PLATFORMS
from haptid.report.posterior.overview import relative_widths

TRUTH = {
    "inertia": 0.012, "gravity_sin": 0.3, "Ks": 0.4, "sigma0": 30.0, "sigma1": 0.1, "sigma2": 0.02, "vs": 0.2,
    "Fs": 0.04, "Fc": 0.03,
}  # fmt: skip
"""Numbers in the page's own simulation."""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, python_api.Ran]]:
    folder = tmp_path_factory.mktemp("page")
    yield folder, python_api.run_page(folder)
    plt.close("all")


@pytest.fixture(autouse=True)
def few_figures() -> Iterator[None]:
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def identified(page) -> Identified:
    return page[1].names["identified"]


@pytest.fixture(scope="module")
def posteriors(page) -> Posteriors:
    return page[1].names["posteriors"]


@pytest.fixture(scope="module")
def missing(page) -> Missing:
    return page[1].names["missing"]


@pytest.mark.long
def test_the_page_prints_what_it_shows(page):
    shown = "".join(python_api.blocks("text"))
    assert page[1].printed == shown
    assert len(PLATFORMS) == 5, "the page says how many platforms a native FMU is compiled for"


@pytest.mark.long
def test_the_figure_of_the_page_is_drawn_by_its_code(page):
    drawn, stored = (matplotlib.image.imread(path) for path in (page[0] / python_api.DRAWN, python_api.FIGURE))
    assert drawn.shape == stored.shape
    # Fonts differ by version of Matplotlib, curves do not.
    assert np.mean(np.abs(drawn - stored)) < 0.02


@pytest.mark.long
def test_estimates_are_the_simulated_numbers(identified: Identified):
    found = identified.summary().loc["joint 0"]
    for id, true in TRUTH.items():
        assert found.status[id] == "identified"
        assert abs(found.value[id] - true) < 4 * found["std"][id], id
    assert found.unit["inertia"] == "kg m^2"
    assert identified.runs().rms_over_noise.max() < 1.06
    assert set(identified.runs().use) == {"fit", "validate"}
    assert identified.links().empty


@pytest.mark.long
def test_saved_results_are_the_files_of_the_command(page):
    folder = page[0] / "results"
    written = {path.name for path in folder.iterdir()}
    assert {"identification.json", "report.html", "draws", "joint0.fmu", "joint0_native.fmu"} <= written
    data = json.loads((folder / "identification.json").read_text())
    assert data["complete"]
    assert data["measured"] is False
    assert data["command"] == "haptid.Campaign.identify"
    assert "SYNTHETIC DATA" in (folder / "report.html").read_text()


@pytest.mark.long
def test_stored_results_give_the_same_tables_and_plots(page, identified: Identified):
    campaign = page[1].names["campaign"]
    alone = Identified.read(page[0] / "results")
    assert alone.summary().equals(identified.summary())
    assert alone.runs().equals(identified.runs())
    assert "converged" in str(alone)
    with pytest.raises(InputError, match=r"expected results with their campaign.*Identified.read\(folder, campaign\)"):
        alone.plot_fit()
    again = Identified.read(page[0] / "results", campaign)
    first, second = (one.plot_residuals().get_lines()[0].get_ydata() for one in (identified, again))
    assert np.array_equal(first, second)
    other = Campaign.from_frames(page[1].names["bent"], validate=["unseen"])
    with pytest.raises(InputError, match="expected a fit of this campaign"):
        Identified.read(page[0] / "results", other)


@pytest.mark.long
def test_stored_posteriors_give_the_same_tables_draws_and_plots(page, posteriors: Posteriors):
    stored = Posteriors.read(page[0] / "results")
    assert stored.joints == posteriors.joints == (0,)
    assert stored.sound == posteriors.sound
    assert stored.summary().equals(posteriors.summary())
    assert stored.draws().equals(posteriors.draws())
    assert "inertia" in str(stored)
    assert sorted(stored.to_inference_data()) == sorted(page[1].names["data"])
    for call in ("plot_prediction", "plot_residuals"):
        one, other = (getattr(result, call)(run="unseen").get_lines()[0].get_ydata() for result in (posteriors, stored))
        assert np.array_equal(one, other)
    band = posteriors.of_joint().bands[0]
    assert np.array_equal(stored.plot_residuals(run=band.run.file).get_lines()[0].get_xdata(), band.run.t)
    with pytest.raises(InputError, match="of_joint: expected a sampling of this program"):
        stored.of_joint()
    made = relative_widths(posteriors.of_joint())  # the page's own computation
    kept = stored._read_posterior(0).relative_widths()
    for one, other in zip(made, kept, strict=True):
        assert one == other if isinstance(one, list) else np.allclose(one, other, rtol=1e-9)


@pytest.mark.long
def test_a_stored_finding_gives_the_same_tables_plots_and_fmu(page, missing: Missing, tmp_path: Path):
    kept = missing.save(tmp_path / "kept")
    stored = Missing.read(kept.folder)
    assert (stored.verdict, stored.sentence, stored.title) == (missing.verdict, missing.sentence, "joint 0")
    for name in ("effects", "gap", "alternatives"):
        assert getattr(stored, name).equals(getattr(missing, name)), name
    for call in ("plot_fit", "plot_residuals", "plot_where"):
        one, other = (getattr(result, call)() for result in (missing, stored))
        assert one.get_title() == other.get_title()
        lines = zip(one.get_lines(), other.get_lines(), strict=True)
        assert all(np.array_equal(a.get_xydata(), b.get_xydata()) for a, b in lines)
        bars = zip(one.patches, other.patches, strict=True)
        assert all(np.array_equal(a.get_extents().bounds, b.get_extents().bounds) for a, b in bars)
    assert stored.export_fmu(tmp_path / "again.fmu").read_bytes() == (page[0] / "stiffening.fmu").read_bytes()
    assert "cubic_spring" in str(stored)
    copied = stored.save(tmp_path / "copied")
    assert (copied.folder / "discrepancy" / "joint0.html").is_file()
    assert Missing.read(copied.folder, 0).gap.equals(missing.gap)


@pytest.mark.long
@pytest.mark.parametrize("damage", ["gone", "empty", "cut", "other"])
def test_damaged_files_are_refused_in_one_line(page, missing: Missing, tmp_path: Path, damage: str):
    shutil.copytree(page[0] / "results" / "posterior", tmp_path / "posterior")
    shutil.copy(page[0] / "results" / "posterior.json", tmp_path)
    missing.save(tmp_path)
    chains, curves = tmp_path / "posterior" / "joint0.nc", tmp_path / "discrepancy" / "joint0.npz"
    for path in (chains, curves):
        content = path.read_bytes()
        path.unlink()
        if damage != "gone":
            path.write_bytes({"empty": b"", "cut": content[: len(content) // 2], "other": b"no archive" * 99}[damage])
    for call in (Posteriors.read(tmp_path).plot_prediction, Missing.read(tmp_path).plot_fit):
        with pytest.raises(InputError) as caught:
            call()
        assert "\n" not in str(caught.value)
    (tmp_path / "posterior.json").write_text(
        '{"schema": "posterior/1", "campaign": "x", "measured": true, "joints": []}'
    )
    with pytest.raises(InputError, match=r"posterior\.json"):
        Posteriors.read(tmp_path)
    with pytest.raises(InputError, match=r"expected a finding, one of joint0, got joint7"):
        Missing.read(tmp_path, 7)


@pytest.mark.parametrize(
    ("read", "command"), [(Identified.read, "identify"), (Posteriors.read, "posterior"), (Missing.read, "missing")]
)
def test_a_folder_without_results_says_what_writes_them(tmp_path: Path, read, command: str):
    with pytest.raises(InputError, match=rf"or haptid {command} --out wrote"):
        read(tmp_path)


@pytest.mark.long
def test_exported_fmus_simulate_the_measured_motion(page, identified: Identified):
    run = next(run for run in identified.values.runs if run.use == "validate")
    torque = np.array(list(zip(run.t, run.u[:, 0], strict=True)), dtype=[("time", float), ("joint0.torque", float)])
    for name in ("pendulum.fmu", "pendulum_native.fmu"):
        result = fmpy.simulate_fmu(
            str(page[0] / name),
            stop_time=1.0,
            step_size=0.01,
            output_interval=0.01,
            input=torque,
            output=["joint0.position"],
        )
        rows = np.round(result["time"] / 0.01).astype(int)
        assert np.abs(result["joint0.position"] - run.y[rows, 0]).max() < 2e-2, name


@pytest.mark.long
def test_plots_draw_on_the_axes_that_they_are_given(identified: Identified, posteriors: Posteriors, missing: Missing):
    calls = (
        identified.plot_fit, identified.plot_residuals, posteriors.plot_widths, posteriors.plot_prediction,
        posteriors.plot_residuals, missing.plot_fit, missing.plot_residuals, missing.plot_where,
        lambda ax: posteriors.plot_marginal("Fc", ax=ax),
    )  # fmt: skip
    for call in calls:
        figure, ax = plt.subplots()
        assert call(ax=ax) is ax
        assert ax.has_data()
        assert ax.get_xlabel()
        assert figure.axes == [ax]
    assert isinstance(identified.plot_fit(0), Axes)


@pytest.mark.long
def test_wrong_names_are_refused_in_one_line(identified: Identified, posteriors: Posteriors, missing: Missing):
    cases = (
        (lambda: identified.plot_fit(3), "joint: expected one of the joints 0, got 3"),
        (lambda: identified.plot_fit(run="none"), r"run: expected a run of joint 0 \(slow, fast, unseen\), got 'none'"),
        (lambda: identified.find_missing(without=["no_such"]), "without: expected ids of the catalogue, got no_such"),
        (lambda: identified.find_missing((0, 1)), "joint 0,1: expected runs in which these joints move together"),
        (lambda: posteriors.plot_marginal("mass"), "parameter: expected one of inertia, "),
        (lambda: posteriors.plot_prediction(run="none"), r"run: expected a run of joint 0 \(unseen, slow, fast\)"),
        (lambda: missing.plot_where("colour"), "variable: expected one of position_rad, "),
        (lambda: identified.posterior(3), r"joints: expected joints with runs to fit \(0\), got 3"),
        (lambda: identified.plot_fit(ax=plt.figure()), r"ax: expected Axes .*, got one Figure; give figure.gca\(\)"),
        (lambda: posteriors.plot_widths(ax=plt.figure()), r"ax: expected Axes .*, got one Figure; "),
        (lambda: missing.plot_where(ax=plt.figure()), r"ax: expected Axes .*, got one Figure; "),
    )
    for call, told in cases:
        with pytest.raises(InputError, match=told) as caught:
            call()
        assert "\n" not in str(caught.value)


@pytest.mark.long
def test_posteriors_agree_with_the_truth_and_with_arviz(page, posteriors: Posteriors):
    table = posteriors.summary().loc[0]
    for id, true in TRUTH.items():
        assert abs(table["mean"][id] - true) < 4.5 * table["std"][id], id
        assert table.lower_95[id] < table["median"][id] < table.upper_95[id]
    data = page[1].names["data"]
    assert float(data.posterior["Ks"].mean()) == pytest.approx(posteriors.draws()["Ks"].mean())
    assert data.posterior["Ks"].dims == ("chain", "draw")
    assert (page[0] / "results" / "posterior" / "joint0.nc").is_file()
    assert "read from identification.json" in " ".join(posteriors.of_joint().notes)


@pytest.mark.long
def test_what_is_missing_is_named_and_closes_the_gap(page, missing: Missing):
    assert missing.verdict == "named"
    k3 = missing.effects.loc["cubic_spring", "k3"]
    assert abs(k3.value - 0.1) < 4 * k3["std"]
    assert k3.unit == "N m/rad^3"
    gap = missing.gap.loc["validate"]
    assert gap.before > 1.4 * gap.noise > 1.2 * gap.after
    assert gap.unit == "rad"
    variables = {v.name for v in fmpy.read_model_description(page[0] / "stiffening.fmu").modelVariables}
    assert any("cubic" in name or "k3" in name for name in variables)


@pytest.mark.long
def test_notebooks_show_tables_with_the_synthetic_label(page, identified: Identified, posteriors: Posteriors, missing):
    results = (page[1].names["campaign"], identified, posteriors, missing)
    for result in results:
        html = result._repr_html_()
        assert "SYNTHETIC DATA" in html
        assert "<table" in html
        assert "<script" not in html
        assert "\n" not in repr(result)
    assert "cubic_spring" in missing._repr_html_()


@pytest.mark.long
def test_temporary_files_live_as_long_as_the_results(page):
    second = page[1].names["second"]
    assert second.folder.is_dir()
    assert page[1].names["missing"].place is second.place


def test_the_reference_names_every_public_call():
    text = api_page()
    for one in CLASSES:
        assert f"## {one.__name__}\n" in text
    for call in ("Campaign.from_frames", "Identified.export_fmu", "Posteriors.to_inference_data", "Missing.save"):
        assert f"### `{call}`" in text
    assert "hold: Hold = 'zero'" in text
