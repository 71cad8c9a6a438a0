"""`Campaign`, where every Python program begins: measurements in; fits, posteriors and findings by one call each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import pandas as pd

from haptid.api.arguments import (
    check_choice,
    errors_name_arguments,
    joints_of,
    listener_of,
    names_of_runs,
    number_of,
    tables_of_joints,
    texts_by_text,
)
from haptid.api.find_missing import find_values
from haptid.api.identified import Identified, complete
from haptid.api.identify import identify_values
from haptid.api.missing import Missing
from haptid.api.place import Place, lock_place
from haptid.api.shown import html_of
from haptid.discrepancy.job.job import MOST_EFFORT, MOST_STARTS
from haptid.fmu_build.building.packaging import Kind
from haptid.identification.problem.options import FitOptions
from haptid.measurement.checks.preparation import ready_for_fits
from haptid.measurement.checks.summary import summarise
from haptid.measurement.format.devices import SINGLE_JOINT
from haptid.measurement.format.embedded import Embedded, choose_campaign
from haptid.measurement.format.places import outside_allowed
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.making.answers import Answers, find_device, select_runs
from haptid.measurement.making.frames import campaign_from_frames, frames_by_name
from haptid.measurement.naming.map_option import parse_map
from haptid.measurement.values.campaign import Campaign as Values
from haptid.measurement.values.run import Hold, Run
from haptid.model.device.device import Device
from haptid.report.identification.drawings import Drawings
from haptid.support.installing.extras import need
from haptid.support.listener import Listener

if TYPE_CHECKING:
    from haptid.api.posteriors import Posteriors

CALL = "haptid.Campaign."
"""Stands in results where a command stands that made them."""


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Campaign:
    """Measurements of one device, ready for fits.

    Make one by `from_frames` or `read`.

    Parameters
    ----------
    values
        The campaign as all packages take it.

    Notes
    -----
    This object holds the frozen `haptid.measurement.values.campaign.Campaign` and is none itself: that value is the
    base on which fits and searches stand, so that it cannot have methods that start them.
    """

    values: Values

    @classmethod
    def read(
        cls, folder: Path | str | None = None, *, embedded: Embedded | None = None, allow_outside: bool = False
    ) -> Campaign:
        """Read a campaign from a folder with ``campaign.toml``.

        Parameters
        ----------
        folder
            The folder; None for a synthetic Freedom 6S campaign that comes with haptid.
        embedded
            Which one: ``planned`` (None as well), with tests in planned lock postures, or ``paper``, the paper's
            protocol alone.
        allow_outside
            Whether the campaign may name files outside its folder.

        Returns
        -------
        Campaign
            Noise and encoder step are estimated where the campaign states none, and runs are held out where none
            validates.

        Raises
        ------
        InputError
            With file, line and key of the first fault; also where the campaign allows no fit.

        Warns
        -----
        CampaignWarning
            For what is odd and still usable, as unknown columns.
        """
        with errors_name_arguments(), outside_allowed(allow_outside):
            return cls(ready_for_fits(read_campaign(choose_campaign(folder, embedded))))

    @classmethod
    def from_frames(  # noqa: PLR0913 # each says one thing of the tables
        cls,
        frames: Mapping[str, pd.DataFrame] | Sequence[pd.DataFrame],
        *,
        device: str | Path | Device = SINGLE_JOINT,
        measured: bool = True,
        title: str = "",
        validate: str | Sequence[str] | None = (),
        free: int | Sequence[int] | None = None,
        noise: float | None = None,
        resolution: float | None = None,
        hold: Hold = "zero",
        columns: Mapping[str, str] | None = None,
        joints: Mapping[int, Mapping[str, Any]] | None = None,
    ) -> Campaign:
        """Make a campaign of data frames, one a run.

        Parameters
        ----------
        frames
            Tables by the name of their run, or in a list (then ``run0``, ``run1`` …). Columns are those of a run's
            file: ``time_s``, ``torque_<j>_Nm``, ``position_<j>_rad``; names such as ``Angle (deg)`` or ``tau1_mNm`` are
            understood and converted. The index counts for nothing. A time may be numbers, dates or durations. Positions
            are counted on where they wrap, and a run is cut where rows are lost, into ``<name>_1``, ``<name>_2`` …. An
            empty cell or a repeated time is an error: leave such rows out by ``df.dropna()`` and
            ``df.drop_duplicates("time_s")``.
        device
            Built-in name, path of a device TOML or URDF, a loaded `Device`, or ``single_joint`` for any one joint.
        measured
            False for simulated data; every result says so.
        title
            One line that names the tests.
        validate
            Names of the runs that are kept from every fit; patterns such as ``val_*`` are allowed. Where none is named
            (None, too), the last third of the longest run is held out.
        free
            Joints that move in all runs; None for those that do in each.
        noise
            Standard deviation of the position's noise [rad] ([m]), by which fits weigh the rows and results measure
            their residuals; None to estimate it.
        resolution
            Encoder step [rad] ([m]), which is also the size of one count; None to estimate it.
        hold
            Torque between rows: ``zero`` holds it, ``linear`` interpolates it.
        columns
            Meaning of columns whose names do not say it: ``{"M": "torque_0_Nm*0.001"}``.
        joints
            What is known of the joints, as the tables ``[joint.J]`` of ``campaign.toml``:
            ``{0: {"friction": "dahl", "parameters": {"Kp": {"fixed": 1.0}}}}``. Columns of a voltage or a
            duty are a drive of that kind; ``{0: {"drive": {"kind": "voltage", "resistance_ohm": 3.0}}}`` states what is
            known of it.

        Returns
        -------
        Campaign
            See `read`.

        Raises
        ------
        InputError
            With run, row and column of the first fault.

        Warns
        -----
        CampaignWarning
            See `read`; also for each position that is counted on, each run that is cut, and a time without a unit,
            which is taken in the only one that the interval of its rows allows. These stand in `remarks`, too.
        """
        with errors_name_arguments():
            tables = frames_by_name(frames)
            meanings = texts_by_text("columns", columns, '{"M": "torque_0_Nm"}')
            answers = Answers(
                title=title or "campaign from data frames",
                device=device if isinstance(device, Device) else find_device(str(device), Path()),
                measured=measured,
                hold=hold,
                noise=number_of("noise", noise),
                resolution=number_of("resolution", resolution),
                validate=select_runs(names_of_runs("validate", validate, tables), tuple(tables)),
                free=joints_of("free", free),
                stated=parse_map(tuple(f"{column}={target}" for column, target in meanings.items())),
            )
            return cls(ready_for_fits(campaign_from_frames(tables, answers, tables_of_joints("joints", joints))))

    @property
    def title(self) -> str:
        """One line that names the tests."""
        return self.values.title

    @property
    def measured(self) -> bool:
        """False for simulated data."""
        return self.values.measured

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints that some run frees alone, ascending."""
        return self.values.joints

    @property
    def runs(self) -> tuple[Run, ...]:
        """Runs with their arrays, in SI units."""
        return self.values.runs

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on likely slips of units, signs, columns and clocks."""
        return self.values.remarks

    def summary(self) -> pd.DataFrame:
        """Return the facts of every joint of every run.

        Returns
        -------
        DataFrame
            One row a run and joint: rows, duration, rate, torque, travel, frequency, cycles, noise and encoder step, in
            SI units by the name of the column.
        """
        facts = pd.DataFrame([row.facts for row in summarise(self.values)])
        # The values are those that fits use; which of them were stated is no longer known here.
        return facts.drop(columns=["noise_stated", "resolution_stated"])

    def identify(  # noqa: PLR0913 # one argument a choice
        self,
        joints: int | Sequence[int] | None = None,
        *,
        folder: Path | str | None = None,
        kind: Kind | None = "python",
        options: FitOptions | None = None,
        workers: int | None = None,
        scheduler: str | None = None,
        fmus: bool = True,
        progress: bool | Listener | None = None,
    ) -> Identified:
        """Fit joint by joint in locking order, and verify the whole device; the same as ``haptid identify``.

        Parameters
        ----------
        joints
            Only this joint, or these; None for all.
        folder
            Folder in which everything is written that ``haptid identify`` writes. An interrupted call with the same
            folder goes on from the joints that were finished. None for a temporary one, without report and FMUs.
        kind
            Packaging of the FMU that the fits run; None runs the compiled kernel in process, with the same results and
            sooner.
        options
            Choices of the fits, ``FitOptions(starts=8, seed=0, …)``.
        workers
            Processes on this machine; those of ``options``, one as a rule, where None. A program that asks for several
            needs ``if __name__ == "__main__":``.
        scheduler
            Address of a running Dask scheduler to use instead of processes here.
        fmus
            Whether FMUs are written to ``folder``.
        progress
            Whether a bar is shown on stderr, or who listens. None shows it on a terminal and in a notebook.

        Returns
        -------
        Identified
            Estimates with their uncertainty, and what they are worth on runs that no fit saw.

        Raises
        ------
        InputError
            Where an argument is at fault.
        NumericalError
            Where a fit fails.
        """
        options = options or FitOptions()
        if workers is not None:
            options = options.but(workers=workers)
        # Nobody sees the report of a temporary folder.
        drawings = Drawings(options.workers if folder is not None else 1)
        with errors_name_arguments(), lock_place(folder), listener_of(progress) as listener, drawings:
            if kind is not None:
                check_choice("kind", kind, get_args(Kind))
            made = identify_values(
                self.values, Place.of(folder), listener, drawings,
                joints=joints_of("joints", joints), kind=kind, options=options,
                scheduler=scheduler, made_by=f"{CALL}identify",
            )  # fmt: skip
            kept = not made.place.temporary
            complete(made, listener, drawings, report=kept, fmus=fmus and kept)
            return made

    def posterior(  # noqa: PLR0913 # one argument a choice
        self,
        joints: int | Sequence[int] | None = None,
        *,
        folder: Path | str | None = None,
        quick: bool = False,
        sensitivity: bool = False,
        kind: Kind | None = None,
        seed: int = 0,
        workers: int = 1,
        scheduler: str | None = None,
        progress: bool | Listener | None = None,
    ) -> Posteriors:
        """Sample the posterior of every joint's parameters; the same as ``haptid posterior``.

        It needs the extra ``posterior``. `Identified.posterior` goes on from fits that are made already.

        Parameters
        ----------
        joints
            Only this joint, or these; None for all.
        folder
            Folder in which everything is written that ``haptid posterior`` writes. The sampling begins at the fits that
            an ``identification.json`` there holds. None for a temporary one.
        quick
            Whether the climbs that choose the noise model and the chains are short, for a first look. The results say
            so; where many or fast rows make each step dear, ensembles and steps are fewer.
        sensitivity
            Whether mean and standard deviation are also computed with all priors half and twice as wide.
        kind
            Packaging of the FMU that the sampler runs; None runs the compiled kernel of the same equations.
        seed
            The same seed gives the same draws.
        workers
            Processes on this machine. A program that asks for several needs ``if __name__ == "__main__":``.
        scheduler
            Address of a running Dask scheduler to use instead.
        progress
            Whether a bar is shown on stderr, or who listens. None shows it on a terminal and in a notebook.

        Returns
        -------
        Posteriors
            Draws, intervals, predictive bands and diagnostics of each joint.

        Raises
        ------
        InputError
            Where an argument is at fault, or the extra is not installed.
        NumericalError
            Where a posterior is not finite.
        """
        need("posterior", "posterior")
        from haptid.api.posteriors import sample_values  # noqa: PLC0415 (its packages are that extra)

        with errors_name_arguments(), lock_place(folder), listener_of(progress) as listener:
            if kind is not None:
                check_choice("kind", kind, get_args(Kind))
            return sample_values(
                self.values, Place.of(folder), listener, joints=joints_of("joints", joints), quick=quick,
                sensitivity=sensitivity, kind=kind, seed=seed, workers=workers, scheduler=scheduler,
                made_by=f"{CALL}posterior",
            )  # fmt: skip

    def find_missing(  # noqa: PLR0913 # one argument a choice
        self,
        joint: int | Sequence[int] | None = None,
        *,
        folder: Path | str | None = None,
        without: Sequence[str] = (),
        own_effects: Path | str | None = None,
        kind: Kind = "python",
        seed: int = 0,
        starts: int = MOST_STARTS,
        effort: int = MOST_EFFORT,
        workers: int = 1,
        progress: bool | Listener | None = None,
    ) -> Missing:
        """Find what is missing in a joint's model, name it and show the gap shrink; the same as ``haptid missing``.

        `Identified.find_missing` goes on from fits that are made already.

        Parameters
        ----------
        joint
            Number of the joint, studied in the runs in which it moves alone; several numbers for the runs in which
            exactly these move together. None for the only joint.
        folder
            Folder in which everything is written that ``haptid missing`` writes. The search begins at the fits that an
            ``identification.json`` there holds, and knows earlier findings there. None for a temporary one.
        without
            Ids of effects to leave out of the catalogue.
        own_effects
            Folder with effects of your own, one file each.
        kind
            Packaging of the FMU with the named effects.
        seed, starts
            Seed and most starts of the nominal fit.
        effort
            Simulated runs after which no further combinations of effects are tried.
        workers
            Threads that simulate runs side by side.
        progress
            Whether a bar is shown on stderr, or who listens. None shows it on a terminal and in a notebook.

        Returns
        -------
        Missing
            Verdict, named effects, and the gap before and after.

        Raises
        ------
        InputError
            Where an argument is at fault.
        NumericalError
            Where no start of the nominal fit gives a finite simulation.
        """
        with errors_name_arguments(), lock_place(folder), listener_of(progress) as listener:
            return find_values(
                self.values, joint, Place.of(folder), listener, without=without,
                own_effects=None if own_effects is None else Path(own_effects), kind=kind, seed=seed, starts=starts,
                effort=effort, workers=workers,
            )  # fmt: skip

    def __repr__(self) -> str:
        """Return title, joints and number of runs in a line."""
        joints = "; ".join("+".join(map(str, free)) for free in self.values.configurations)
        return f"Campaign({self.title!r}: {len(self.runs)} runs, free joints {joints}, {self.values.label} data)"

    def _repr_html_(self) -> str:
        """Return the facts of all runs for a notebook."""
        said = " ".join(self.remarks) or "No remarks on the data."
        return html_of(self.title, said, {"runs": self.summary()}, measured=self.measured)
