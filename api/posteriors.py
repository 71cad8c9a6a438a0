"""`Posteriors`, the result of a sampling: intervals, plots of draws and bands, and ArviZ's `InferenceData`."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from haptid.api.arguments import check_workers, errors_name_arguments, only_one
from haptid.api.place import Place, lock_place, require_result, word_origin
from haptid.api.shown import axes_or_new, html_of
from haptid.fmu_build.accuracy.stored_draws import POSTERIOR
from haptid.fmu_build.building.packaging import Kind
from haptid.identification.verification.result import Verification
from haptid.identification.workers.chosen_workers import workers_of
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign as Values
from haptid.report.common.linked_pages import link_pages
from haptid.report.common.stored_page import write_page
from haptid.report.common.style import style
from haptid.report.discrepancy.full_model_section import full_model_sections
from haptid.report.posterior.figures import draw_band, draw_marginal, draw_residual_bands, draw_widths
from haptid.report.posterior.overview import lead
from haptid.report.posterior.page import posterior_page
from haptid.support.errors import InputError
from haptid.support.files.files import read_json
from haptid.support.listener import Listener
from haptid.support.tables import text_of
from haptid.uq.job.job import Job
from haptid.uq.job.sample import Sampled, sample_joints
from haptid.uq.job.summary import tell_posterior
from haptid.uq.job.written import chains_file, write_chains, write_posteriors
from haptid.uq.prediction.predict import Bands
from haptid.uq.result.full_model import full_model_bands
from haptid.uq.result.infer import QUICK, InferOptions
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.stored import StoredPosterior, read_chains
from haptid.uq.sampling.sampling import SamplingOptions

SUMMARY = ("mean", "std", "median", "unit", "rhat", "ess_bulk", "verdict")
"""Keys of a parameter in ``posterior.json`` that a table shows beside its 95 % interval."""


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Posteriors:
    """Posteriors of the joints of a campaign.

    Make them by `Campaign.posterior` or `Identified.posterior`, or by `Posteriors.read` from a folder that ``haptid
    posterior`` wrote.

    Parameters
    ----------
    posteriors
        One for each joint, in locking order; none where the results were read.
    full
        Bands of runs with all joints free; without runs where a joint has no posterior, or the results were read.
    data
        Content of ``posterior.json``.
    place
        Folder of the results.
    values
        The campaign; None where the results were read.
    made_by
        Command or call, for the reader of the page.
    """

    posteriors: tuple[Posterior, ...]
    full: Verification
    data: dict[str, Any]
    place: Place
    values: Values | None
    made_by: str

    @classmethod
    def read(cls, folder: Path | str) -> Posteriors:
        """Read what a sampling wrote.

        Parameters
        ----------
        folder
            Folder with ``posterior.json``.

        Returns
        -------
        Posteriors
            With tables, draws, plots and ArviZ's data; what `of_joint` returns is not stored.

        Raises
        ------
        InputError
            Where the file is at fault, or holds the posterior of an FMU that has no joints.
        """
        source = Path(folder) / POSTERIOR
        require_result(source, "a posterior.json", word_origin("posterior", "posterior"))
        data = read_json(source, "a posterior.json", ("haptid.uq.result", "posterior.schema.json"))
        place, none = Place.existing(folder), Verification(runs=())
        return cls(posteriors=(), full=none, data=data, place=place, values=None, made_by="")

    @property
    def folder(self) -> Path:
        """Folder with ``posterior.json``, draws and chains; a temporary one lives as long as this result."""
        return self.place.path

    @property
    def joints(self) -> tuple[int, ...]:
        """Numbers of the sampled joints."""
        return tuple(one["joint"] for one in self.data["joints"])

    @property
    def sound(self) -> bool:
        """Whether the independent ensembles of all joints agree and their chains are long enough."""
        return all(one["sound"] for one in self.data["joints"])

    def of_joint(self, joint: int | None = None) -> Posterior:
        """Return everything that is known of one joint.

        Parameters
        ----------
        joint
            Number of the joint; None for the only one.

        Returns
        -------
        haptid.uq.result.posterior.Posterior
            Chains, noise models, scores, bands and the proposed next run.

        Raises
        ------
        InputError
            Where the joint was not sampled, or the results were read.
        """
        number = only_one(joint, self.joints)
        if not self.posteriors:
            todo = "summary(), draws(), to_inference_data() and the plots know what is stored"
            raise InputError("of_joint", expected="a sampling of this program", got="results read", todo=todo)
        return next(one for one in self.posteriors if one.joint == number)

    def summary(self) -> pd.DataFrame:
        """Return how well each parameter is known.

        Returns
        -------
        DataFrame
            One row a joint and parameter, those of the noise model included: mean, standard deviation, median, ends of
            the equal-tailed 95 % interval, unit, R̂, effective sample size, and a sentence.
        """
        rows = []
        for joint in self.data["joints"]:
            for id, one in joint["parameters"].items():
                low, high = one["intervals"]["0.95"]
                known = {key: one[key] for key in SUMMARY}
                rows.append({"joint": joint["joint"], "parameter": id, **known, "lower_95": low, "upper_95": high})
        order = [*SUMMARY[:3], "lower_95", "upper_95", *SUMMARY[3:]]
        return pd.DataFrame(rows).set_index(["joint", "parameter"])[order]

    def draws(self, joint: int | None = None) -> pd.DataFrame:
        """Return draws of a joint's parameters.

        Parameters
        ----------
        joint
            Number of the joint; None for the only one.

        Returns
        -------
        DataFrame
            One row a draw, one column a parameter in its unit, those of the noise model included.

        Raises
        ------
        InputError
            Where the joint was not sampled.
        """
        return pd.DataFrame(dict(self._read_posterior(joint).posterior))

    def plot_marginal(self, parameter: str, joint: int | None = None, *, ax: Axes | None = None) -> Axes:
        """Plot the histogram of a parameter's draws over that of its prior.

        Parameters
        ----------
        parameter
            Id of the parameter.
        joint
            Number of the joint; None for the only one.
        ax
            Axes to draw on; None for new ones.

        Returns
        -------
        Axes
            The axes, the parameter in its unit.

        Raises
        ------
        InputError
            Where there is no such joint or parameter.
        """
        stored = self._read_posterior(joint)
        if parameter not in stored.posterior:
            raise InputError("parameter", expected=f"one of {', '.join(stored.posterior)}", got=repr(parameter))
        unit = stored.unit(parameter)
        axes = axes_or_new(ax)
        with style():
            label = parameter if unit == "1" else f"{parameter} [{unit}]"
            draw_marginal(axes, stored.posterior[parameter], stored.prior[parameter], label)
        return axes

    def plot_widths(self, joint: int | None = None, *, ax: Axes | None = None) -> Axes:
        """Plot the width of each parameter's 95 % interval within that of its prior.

        Parameters
        ----------
        joint
            Number of the joint; None for the only one.
        ax
            Axes to draw on; None for new ones.

        Returns
        -------
        Axes
            The axes, half-widths in percent of the value.

        Raises
        ------
        InputError
            Where the joint was not sampled.
        """
        stored = self._read_posterior(joint)
        axes = axes_or_new(ax)
        with style():
            draw_widths(axes, *stored.relative_widths())
        return axes

    def plot_prediction(self, joint: int | None = None, *, run: str | None = None, ax: Axes | None = None) -> Axes:
        """Plot what was measured of a run over its predictive 95 % band.

        Parameters
        ----------
        joint
            Number of the joint; None for the only one.
        run
            File (name) of the run; None for the first one that no fit saw.
        ax
            Axes to draw on; None for new ones.

        Returns
        -------
        Axes
            The axes, position in rad or m; torque in N m or N where the torque was fitted.

        Raises
        ------
        InputError
            Where there is no such joint or run.
        """
        bands = self._bands(joint, run)
        axes = axes_or_new(ax)
        with style():
            draw_band(axes, bands)
            axes.set_xlabel("time [s]")
            axes.legend()
        return axes

    def plot_residuals(self, joint: int | None = None, *, run: str | None = None, ax: Axes | None = None) -> Axes:
        """Plot what was measured of a run minus the predictive median, over the bands of 50, 80 and 95 %.

        Parameters
        ----------
        joint, run, ax
            As `plot_prediction` takes them.

        Returns
        -------
        Axes
            The axes, residual in thousandths of the unit of `plot_prediction`.

        Raises
        ------
        InputError
            Where there is no such joint or run.
        """
        bands = self._bands(joint, run)
        axes = axes_or_new(ax)
        with style():
            draw_residual_bands(axes, bands)
            axes.set_xlabel("time [s]")
        return axes

    def to_inference_data(self, joint: int | None = None) -> Any:
        """Return chains, prior, log densities and measured positions of a joint for ArviZ.

        It is the file ``posterior/joint<j>.nc`` of the results, in memory.

        Parameters
        ----------
        joint
            Number of the joint; None for the only one.

        Returns
        -------
        arviz.InferenceData, or xarray.DataTree of ArviZ 1
            Groups ``posterior``, ``prior``, ``log_likelihood`` (by cycle and by run), ``observed_data`` and
            ``constant_data`` (edges of the bands).

        Raises
        ------
        InputError
            Where the joint was not sampled.
        """
        return read_chains(chains_file(self.folder, only_one(joint, self.joints)))

    def save(self, folder: Path | str) -> Posteriors:
        """Write everything that ``haptid posterior`` writes: JSON, page, draws and chains.

        Parameters
        ----------
        folder
            Folder that may not exist yet; files of the same names are replaced.

        Returns
        -------
        Posteriors
            This result with ``folder`` as its folder. One that was read is copied as it is.

        Raises
        ------
        InputError, WritingError
            Where the folder cannot be written.
        """
        with errors_name_arguments(), lock_place(folder):
            saved = replace(self, place=self.place.copy_to(folder))
            _write_page(saved)
            return saved

    def __str__(self) -> str:
        """Return the summary that ``haptid posterior`` prints."""
        if not self.posteriors:
            return str(self.summary().to_string())
        return "\n".join(text_of(tell_posterior(one)) for one in self.posteriors)

    def __repr__(self) -> str:
        """Return campaign and joints in a line."""
        return f"Posteriors({self.data['campaign']!r}: joints {', '.join(map(str, self.joints))})"

    def _repr_html_(self) -> str:
        """Return verdict and intervals for a notebook."""
        tables = {"parameters": self.summary()}
        said = lead(self.posteriors) if self.posteriors else self._describe_chains()
        return html_of(self.data["campaign"], said, tables, measured=bool(self.data["measured"]))

    def _describe_chains(self) -> str:
        """Return a sentence on the chains of results that were read."""
        # Results of an earlier version say that chains are not sound, and not why.
        unsound = [
            (one["joint"], one.get("state", "short or disagree")) for one in self.data["joints"] if not one["sound"]
        ]
        if unsound:
            told = ", ".join(f"joint {joint} ({state.replace('_', ' ')})" for joint, state in unsound)
            return f"Chains that are not sound: {told}."
        return "The chains of all joints are long enough and agree."

    def _read_posterior(self, joint: int | None) -> StoredPosterior:
        """Read the files of a joint, which hold all that is drawn."""
        number = only_one(joint, self.joints)
        entry = next(one for one in self.data["joints"] if one["joint"] == number)
        return StoredPosterior.read(chains_file(self.folder, number), entry)

    def _bands(self, joint: int | None, run: str | None) -> Bands:
        stored = self._read_posterior(joint)
        # What no fit saw comes first; the sort keeps the order of the campaign.
        bands = sorted(stored.bands, key=lambda part: part.run.use != "validate")
        chosen = [part for part in bands if run in (None, part.run.file)]
        if not chosen:
            files = ", ".join(part.run.file for part in bands)
            raise InputError("run", expected=f"a run of joint {stored.entry['joint']} ({files})", got=repr(run))
        return chosen[0]


def sample_values(  # noqa: PLR0913 # one argument a choice
    values: Values,
    place: Place,
    listener: Listener,
    *,
    joints: tuple[int, ...] | None,
    quick: bool,
    sensitivity: bool = False,
    kind: Kind | None = None,
    seed: int,
    workers: int,
    scheduler: str | None = None,
    made_by: str,
) -> Posteriors:
    """Sample the joints of a campaign; what is finished is in the folder after each.

    Parameters
    ----------
    values
        Campaign that is ready for fits.
    place
        Folder of the results, perhaps with those of an identification.
    listener
        Told of remarks, of each step, and of each finished joint.
    joints, quick, sensitivity, kind, seed, workers, scheduler
        As `Campaign.posterior` takes them.
    made_by
        Command or call, for the reader of the page.

    Returns
    -------
    Posteriors

    Raises
    ------
    InputError, NumericalError
        As `Campaign.posterior`.
    """
    check_workers(workers)
    device = device_of(values)
    sampling = replace(QUICK if quick else SamplingOptions(), seed=seed)
    options = InferOptions(sampling=sampling, noise_given=values.noise_given, sensitivity=sensitivity, short=quick)
    job = Job(campaign=values, device=device, out=place.path, options=options, kind=kind)
    configurations = job.configurations(joints)
    done: list[Sampled] = []

    def keep(full: Verification) -> Posteriors:
        """Write the joints that are finished so far: an interrupted sampling keeps them."""
        made = tuple(one.posterior for one in done)
        data = write_posteriors(job, done, full)
        result = Posteriors(posteriors=made, full=full, data=data, place=place, values=values, made_by=made_by)
        if not place.temporary:
            _write_page(result)
        return result

    none = Verification(runs=())
    with workers_of(scheduler, workers) as pool:
        for one in sample_joints(job, configurations, pool, listener):
            done.append(one)
            write_chains(job, one.posterior)
            result = keep(none)
            listener.finished(tell_posterior(one.posterior))
    if device is not None:
        result = keep(full_model_bands(values, device, [one.step for one in done], seed=seed))
    return result


def _write_page(result: Posteriors) -> None:
    """Write the page of a sampling; one that was read has it."""
    if result.values is None:
        return
    made_by = f"{result.made_by}, seed {result.data['seed']}, {time.strftime('%Y-%m-%d')}"
    page = posterior_page(
        result.posteriors,
        title="How well the parameters are known",
        synthetic=not result.values.measured,
        footer=[made_by, result.values.title],
        full=full_model_sections(result.full),
        files=[chains_file(Path(), one.joint).as_posix() for one in result.posteriors] + ["posterior.json"],
    )
    write_page(result.folder / "posterior.html", page)
    link_pages(result.folder)
