"""`Identified`, the result of an identification: tables, plots, FMUs; just made, or read from a command's folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import pandas as pd
from matplotlib.axes import Axes

from haptid.api.arguments import HoldsCampaign, check_choice, errors_name_arguments, joints_of, listener_of, only_one
from haptid.api.identified_tables import named_entries, table_estimates, table_links, table_outcomes, table_runs
from haptid.api.place import Place, lock_place, require_result, word_origin
from haptid.api.shown import axes_or_new, html_of
from haptid.fmu_build.building.packaging import Kind
from haptid.fmu_build.exchange.identification_json import read_identification
from haptid.fmu_build.export import package_result
from haptid.fmu_build.multibody.mjcf import FrictionOf
from haptid.fmu_build.multibody.write import Form, multibody_of_result, write_multibody
from haptid.identification.job.export import export_models
from haptid.identification.job.job import Identification
from haptid.identification.job.stored import stored_steps
from haptid.identification.output.summary import tell_summary
from haptid.identification.output.traces import Trace, traces_of
from haptid.identification.sequence.carried_fit import FILE
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.format.devices import device_of
from haptid.measurement.format.embedded import name_of
from haptid.measurement.values.campaign import Campaign as Values
from haptid.measurement.values.warning import warn
from haptid.report.common.linked_pages import link_pages
from haptid.report.common.stored_page import write_page
from haptid.report.common.style import style
from haptid.report.identification.drawings import Drawings
from haptid.report.identification.figures import draw_residual, draw_signal, title_of
from haptid.report.identification.page import Beside, identification_page
from haptid.support.errors import InputError
from haptid.support.installing.extras import need
from haptid.support.listener import Listener
from haptid.support.tables import Told, text_of

if TYPE_CHECKING:
    from haptid.api.missing import Missing
    from haptid.api.posteriors import Posteriors


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Identified:
    """Result of an identification.

    Make one by `Campaign.identify`, or by `Identified.read` from a folder that ``haptid identify`` wrote.

    Parameters
    ----------
    data
        Content of ``identification.json``.
    place
        Folder of the results.
    values
        The campaign; None where the results were read without it, which leaves tables and FMUs.
    steps
        Fitted configurations, in the order of their fits; none without the campaign.
    made
        What the fits gave beside; None where the results were read.
    """

    data: dict[str, Any]
    place: Place
    values: Values | None = None
    steps: tuple[Step, ...] = ()
    made: Identification | None = None

    @classmethod
    def read(cls, folder: Path | str, campaign: HoldsCampaign | None = None) -> Identified:
        """Read what an identification wrote.

        Parameters
        ----------
        folder
            Folder with ``identification.json``.
        campaign
            `haptid.Campaign` that was identified. With it fits can be plotted, posterior and search go on from here.

        Returns
        -------
        Identified

        Raises
        ------
        InputError
            Where the file is at fault, or another campaign or another version of haptid was fitted.
        """
        source = Path(folder) / FILE
        require_result(source, "an identification.json", word_origin("identify", "identify"))
        data = read_identification(source)
        place = Place.existing(folder)
        if campaign is None:
            return cls(data=data, place=place)
        values = campaign.values
        steps = stored_steps(data, values, device_of(values), str(source))
        return cls(data=data, place=place, values=values, steps=steps)

    @property
    def folder(self) -> Path:
        """Folder with ``identification.json`` and the draws; a temporary one lives as long as this result."""
        return self.place.path

    @property
    def measured(self) -> bool:
        """False for simulated data."""
        return bool(self.data["measured"])

    def summary(self) -> pd.DataFrame:
        """Return the estimates.

        Returns
        -------
        DataFrame
            One row a configuration and parameter, and one a constant torque (``offset``) where the plain model is the
            result, which Ks and epos stand for in the FMU: value, standard deviation, unit, status as it is told
            (``identified``, ``uncertain`` where the model leaves more than the noise, ``fixed``, ``prior``,
            ``unidentifiable``, ``at_bound``) and meaning. An unidentifiable value is one of many that fit as well: its
            standard deviation is NaN.
        """
        return table_estimates(self.data)

    def links(self) -> pd.DataFrame:
        """Return the masses, centroids and inertias of the links; empty where the device was not identified as a whole.

        Returns
        -------
        DataFrame
            One row a link and parameter: value, standard deviation, unit and status.
        """
        return table_links(self.data)

    def outcomes(self) -> pd.DataFrame:
        """Return how the fits ended.

        Returns
        -------
        DataFrame
            One row a configuration: outcome, a sentence on it, and the largest RMS over noise of the fitted and of the
            unseen runs.
        """
        return table_outcomes(self.data)

    def runs(self) -> pd.DataFrame:
        """Return the residuals of all runs.

        Returns
        -------
        DataFrame
            One row a configuration and run: use, RMS of measured − simulated, its unit (that of a torque where the
            torque was scored), and RMS over the sensor's noise, 1 for noise alone.
        """
        return table_runs(self.data)

    def plot_fit(self, joint: int | None = None, *, run: str | None = None, ax: Axes | None = None) -> Axes:
        """Plot the measured and the simulated signal of a run over time.

        Parameters
        ----------
        joint
            Number of the joint; None for the only one.
        run
            File (name) of the run; None for the unseen run with the largest residual, or for a fitted one where no run
            was held out.
        ax
            Axes to draw on; None for new ones.

        Returns
        -------
        Axes
            The axes, position in rad or m, torque in N m or N where the torque was scored.

        Raises
        ------
        InputError
            Where there is no such joint or run, or the results were read without their campaign.
        """
        trace, k = self._trace(joint, run)
        axes = axes_or_new(ax)
        with style():
            draw_signal(axes, trace, k)
            _label(axes, trace)
            axes.legend()
        return axes

    def plot_residuals(self, joint: int | None = None, *, run: str | None = None, ax: Axes | None = None) -> Axes:
        """Plot measured minus simulated signal of a run over time, with the sensor's ±2σ.

        Parameters
        ----------
        joint, run, ax
            As `plot_fit` takes them.

        Returns
        -------
        Axes
            The axes, residual in thousandths of the signal's unit.

        Raises
        ------
        InputError
            As `plot_fit`.
        """
        trace, k = self._trace(joint, run)
        axes = axes_or_new(ax)
        with style():
            draw_residual(axes, trace, k)
            _label(axes, trace)
        return axes

    def export_fmu(
        self,
        path: Path | str,
        *,
        joint: int | None = None,
        kind: Kind = "python",
        findings: Sequence[Missing] = (),
    ) -> Path:
        """Write the identified device, or one joint of it, as an FMU; the same as ``haptid export``.

        Parameters
        ----------
        path
            File to write.
        joint
            Number of the joint to export alone; None for the whole device, or for the only joint of a
            ``single_joint`` campaign. In the whole device, first guesses stand where no test gave a value, and the FMU
            says so.
        kind
            ``python`` (built by pythonfmu), ``native`` (compiled, FMI 2.0) or ``native3`` (FMI 3.0).
        findings
            What was found missing in single joints; its effects are taken along.

        Returns
        -------
        Path
            ``path``.

        Raises
        ------
        InputError
            Where there is no such joint, or a finding does not go with the device.

        Warns
        -----
        CampaignWarning
            Where values are none that a real device has.
        """
        with errors_name_arguments():
            check_choice("kind", kind, get_args(Kind))
            packaged = package_result(
                self.folder / FILE,
                Path(path),
                kind,
                joints=None if joint is None else (joint,),
                named=[one.file for one in findings],
                device=None if self.values is None else device_of(self.values),
            )
        for sentence in packaged.warnings:
            warn(f"{path}: {sentence}")
        return packaged.fmu.path

    def export_bodies(
        self,
        path: Path | str,
        *,
        form: Form = "mjcf",
        friction: FrictionOf = "lugre",
    ) -> tuple[str, ...]:
        """Write the bodies of the identified device for other simulators; the same as ``haptid export --kind``.

        Parameters
        ----------
        path
            File to write.
        form
            ``mjcf`` for MuJoCo, ``urdf`` for readers of URDF.
        friction
            Friction of an MJCF: ``lugre``, MuJoCo's LuGre bristle where the joint's law is LuGre, or ``frictionloss``,
            Coulomb and viscous friction alone.

        Returns
        -------
        tuple of str
            Sentences on what the file does not carry.

        Raises
        ------
        InputError
            Where the results are of single joints, or the device is none that such a file can hold.
        """
        with errors_name_arguments():
            check_choice("form", form, get_args(Form))
            check_choice("friction", friction, get_args(FrictionOf))
            device = None if self.values is None else device_of(self.values)
            return write_multibody(multibody_of_result(self.folder / FILE, device), Path(path), form, friction).losses

    def posterior(
        self,
        joints: int | Sequence[int] | None = None,
        *,
        quick: bool = False,
        seed: int = 0,
        workers: int = 1,
        progress: bool | Listener | None = None,
    ) -> Posteriors:
        """Sample the posteriors from these fits on, in the same folder.

        Parameters
        ----------
        joints, quick, seed, workers, progress
            As `Campaign.posterior` takes them, which takes more.

        Returns
        -------
        Posteriors

        Raises
        ------
        InputError, NumericalError
            As `Campaign.posterior`; also where the results were read without their campaign.
        """
        need("posterior", "posterior")
        from haptid.api.posteriors import sample_values  # noqa: PLC0415 (its packages are that extra)

        with errors_name_arguments(), lock_place(self.place.lasting), listener_of(progress) as listener:
            return sample_values(
                self._values("posterior"), self.place, listener, joints=joints_of("joints", joints),
                quick=quick, seed=seed, workers=workers, made_by="haptid.Identified.posterior",
            )  # fmt: skip

    def find_missing(
        self,
        joint: int | Sequence[int] | None = None,
        *,
        without: Sequence[str] = (),
        seed: int = 0,
        workers: int = 1,
        progress: bool | Listener | None = None,
    ) -> Missing:
        """Search for what is missing from these fits on, in the same folder.

        Parameters
        ----------
        joint, without, seed, workers, progress
            As `Campaign.find_missing` takes them, which takes more.

        Returns
        -------
        Missing

        Raises
        ------
        InputError, NumericalError
            As `Campaign.find_missing`; also where the results were read without their campaign.
        """
        from haptid.api.find_missing import find_values  # noqa: PLC0415 (an identification alone need not load the search)

        with errors_name_arguments(), lock_place(self.place.lasting), listener_of(progress) as listener:
            return find_values(
                self._values("find_missing"), joint, self.place, listener, without=without, seed=seed, workers=workers
            )

    def save(self, folder: Path | str, *, fmus: bool = True) -> Identified:
        """Write everything that ``haptid identify`` writes: JSON, report, draws, FMUs and parameter set.

        Parameters
        ----------
        folder
            Folder that may not exist yet; files of the same names are replaced.
        fmus
            Whether FMUs and parameter set are written, too.

        Returns
        -------
        Identified
            This result with ``folder`` as its folder. One that was read is copied as it is.

        Raises
        ------
        InputError, WritingError
            Where the folder cannot be written.
        """
        with errors_name_arguments(), lock_place(folder):
            saved = replace(self, place=self.place.copy_to(folder))
            if self.made is not None:
                complete(saved, Listener(), Drawings(), report=True, fmus=fmus)
            return saved

    def __str__(self) -> str:
        """Return the summary that ``haptid identify`` prints."""
        return text_of(self.told())

    def told(self) -> Told:
        """Tell what ``haptid identify`` tells at its end.

        Returns
        -------
        list
            Tables and sentences; the outcomes alone where stored results were read.
        """
        if self.steps:
            return tell_summary(self.steps, self.data["verification"])
        return [str(self.outcomes().to_string())]

    def __repr__(self) -> str:
        """Return campaign and configurations in a line."""
        return f"Identified({self.data['campaign']!r}: {', '.join(name for name, _ in named_entries(self.data))})"

    def _repr_html_(self) -> str:
        """Return outcomes, residuals and estimates for a notebook."""
        tables = {"outcomes": self.outcomes(), "runs": self.runs(), "parameters": self.summary()}
        said = "RMS over noise is 1 where only the sensor's noise is left."
        return html_of(self.data["campaign"], said, tables, measured=self.measured)

    def _values(self, call: str) -> Values:
        if self.values is None:
            todo = "Identified.read(folder, campaign)"
            raise InputError(call, expected="results with their campaign", got="results read alone", todo=todo)
        return self.values

    def _trace(self, joint: int | None, file: str | None) -> tuple[Trace, int]:
        """Simulate a run of a joint; return its signals, and the place of the joint among its free ones."""
        self._values("plot")
        number = only_one(joint, sorted({j for step in self.steps for j in step.configuration.free_joints}))
        # Tests of the joint alone before those in which others move, too.
        steps = sorted(self.steps, key=lambda step: len(step.configuration.free_joints))
        own = [step for step in steps if number in step.configuration.free_joints]
        known = [score.file for step in own for score in step.fit.runs]
        if file is not None and file not in known:
            raise InputError("run", expected=f"a run of joint {number} ({', '.join(known)})", got=repr(file))
        step = next(step for step in own if file is None or file in [score.file for score in step.fit.runs])
        traces = [t for t in traces_of(step, KernelSimulator.of) if file in (None, t.score.file)]
        # Of a run whose end was held out, and where no run is named, what no fit saw comes first.
        trace = max(traces, key=lambda t: (t.score.use == "validate", t.score.over_noise))
        return trace, trace.joints.index(number)


def _label(axes: Axes, trace: Trace) -> None:
    axes.set_title(title_of(trace), fontsize=8)
    axes.set_xlabel("time [s]")


def complete(identified: Identified, listener: Listener, drawings: Drawings, *, report: bool, fmus: bool) -> list[Path]:
    """Write report, FMUs and parameter set of a new identification into its folder, and mark it as complete.

    Parameters
    ----------
    identified
        Result that was just made.
    listener
        Told of each part.
    drawings
        What is drawn of the configurations so far.
    report
        Whether ``report.html`` is written.
    fmus
        Whether FMUs and parameter set are written.

    Returns
    -------
    list of Path
        FMUs and parameter set.

    Raises
    ------
    InputError, WritingError
        Where the folder cannot be written.
    ValueError
        Where the result was read.
    """
    made, values, folder = identified.made, identified.values, identified.folder
    if made is None or values is None:
        msg = "stored results have their files already"
        raise ValueError(msg)
    if fmus:
        listener.progress("FMUs")
    exported = export_models(made, values, device_of(values), folder) if fmus else []
    if report:
        drawn = drawings.sections(made.steps, made.build, listener)
        files = tuple(path.relative_to(folder).as_posix() for path in exported)
        beside = Beside(files=files, embedded=name_of(values.folder))
        page = identification_page(values.title, made.steps, drawn, made.data, made.verification, beside)
        write_page(folder / "report.html", page)
        link_pages(folder)
    made.finish(folder)
    return exported
