"""`Missing`, the result of a search for missing effects: verdict, named effects, gap, plots and the rebuilt FMU."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from haptid.api.arguments import errors_name_arguments, only_one
from haptid.api.earlier_results import findings_below
from haptid.api.place import Place, lock_place, word_origin
from haptid.api.shown import axes_or_new, html_of
from haptid.discrepancy.finding.drawn import SUFFIX, Drawn
from haptid.discrepancy.finding.finding import Curve, Finding
from haptid.discrepancy.finding.full_model import WholeFinding
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.job.search import (
    AnyFinding,
)
from haptid.discrepancy.job.summary import tell_finding
from haptid.measurement.values.campaign import Campaign as Values
from haptid.measurement.values.units import unit_for
from haptid.report.common.linked_pages import FINDINGS, WHOLE, link_pages
from haptid.report.common.page import Page
from haptid.report.common.stored_page import write_page
from haptid.report.common.style import style
from haptid.report.discrepancy.motion_pictures import draw_motion, draw_residuals, residual_unit
from haptid.report.discrepancy.page import discrepancy_page
from haptid.report.discrepancy.stage_pictures import write_pictures
from haptid.report.discrepancy.torque_gap_page import draw_torque_left, torque_gap_page
from haptid.report.discrepancy.where_pictures import draw_shares
from haptid.report.discrepancy.whole_gap_page import whole_gap_page
from haptid.support.errors import InputError
from haptid.support.files.files import read_json
from haptid.support.tables import Told, text_of


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Missing:
    """What is missing in the model of a joint, if anything.

    Make one by `Campaign.find_missing` or `Identified.find_missing`, or by `Missing.read` from a folder that ``haptid
    missing`` wrote.

    Parameters
    ----------
    finding
        Finding with the search behind it; None where the results were read.
    data
        Content of its file, ``discrepancy/joint<j>.json``.
    name, title
        Name of that file without its suffix, and what was searched, as ``joint 3``.
    place
        Folder of the results.
    values
        The campaign; None where the results were read.
    remark
        What a reader has to know of the readings that were searched; empty where they are those of the campaign.
    left_out
        Which findings of the joints alone the model does not hold, and why; empty where there is none.
    """

    finding: AnyFinding | None
    data: dict[str, Any]
    name: str
    title: str
    place: Place
    values: Values | None
    remark: str = ""
    left_out: str = ""

    @classmethod
    def read(cls, folder: Path | str, joint: int | Sequence[int] | None = None) -> Missing:
        """Read what a search wrote.

        Parameters
        ----------
        folder
            Folder of the results, in which ``discrepancy`` lies.
        joint
            As `Campaign.find_missing` takes it; None for the only finding there.

        Returns
        -------
        Missing
            With tables, plots and FMU; the search behind them is not stored.

        Raises
        ------
        InputError
            Where there is no such finding, or its file is at fault.
        """
        with errors_name_arguments():
            source = _file_of(Path(folder), joint)
            data = read_json(source, "a finding", ("haptid.discrepancy.finding", "finding.schema.json"))
        place = Place.existing(folder)
        return cls(
            finding=None, data=data, name=source.stem, title=_title_of(data, source.stem), place=place, values=None
        )

    @property
    def folder(self) -> Path:
        """Folder of the results; a temporary one lives as long as this result."""
        return self.place.path

    @property
    def file(self) -> Path:
        """File of the finding."""
        return self.folder / FINDINGS / f"{self.name}.json"

    @property
    def verdict(self) -> str:
        """``nothing_missing``, ``named``, ``partly_named``, ``ambiguous`` or ``unlisted``."""
        return str(self.data["verdict"])

    @property
    def sentence(self) -> str:
        """The verdict in words, as an engineer reads it first."""
        return str(self.data["sentence"])

    @property
    def effects(self) -> pd.DataFrame:
        """Named effects: one row an effect and parameter with value, std, unit, evidence and stability."""
        rows = []
        for effect in self.data["effects"]:
            common = {"effect": effect["id"]}
            told = {key: effect.get(key) for key in ("evidence", "stability")}
            parameters = effect.get("parameters") or {"": {}}
            for id, one in parameters.items():
                known = {key: one.get(key) for key in ("value", "std", "unit")}
                rows.append({**common, "parameter": id, **known, **told})
        columns = ["effect", "parameter", "value", "std", "unit", "evidence", "stability"]
        return pd.DataFrame(rows, columns=columns).set_index(["effect", "parameter"])

    @property
    def gap(self) -> pd.DataFrame:
        """RMS before and after: one row a group of runs (``fit``, ``validate``, ``sealed``).

        Columns are ``before``, ``after``, ``noise``, ``closed`` [1], ``floor``, ``black_box`` and ``unit``. A check of
        the whole device has one row a run, mode of simulation and joint.
        """
        rows = {name: gap for name, gap in self.data["gap"].items() if gap is not None}
        if isinstance(rows.get("validate"), list):
            return pd.DataFrame([{**row, "unit": unit_for("rad", [row["prismatic"]])} for row in rows["validate"]])
        columns = list(next(iter(rows.values()))) if rows else ["before", "after", "noise"]
        table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
        return table.assign(unit=self.data.get("gap_unit", ""))

    def summary(self) -> pd.DataFrame:
        """Return verdict, named effects and gap in one table.

        Returns
        -------
        DataFrame
            One row a named effect and parameter: value, standard deviation, unit, evidence and stability; where the
            verdict is ``unlisted``, effects that only stand in for what is missing, as ``stand-in: clock_error``. Below
            the RMS by group of runs, as ``("gap of validate", "before")`` and ``"after"``, with their unit; of a check
            of the whole device by run, mode of simulation and joint. ``attrs`` has ``verdict`` and ``sentence``.
        """
        effects = self.effects
        rows = effects.reset_index().to_dict("records")
        if self.verdict == "unlisted":
            rows = [row | {"effect": f"stand-in: {row['effect']}"} for row in rows]
        for group, gap in self.gap.iterrows():
            of = group if "file" not in gap else f"{gap['file']}, {gap['mode']}, joint {gap['joint']}"
            for moment in ("before", "after"):
                rows.append({"effect": f"gap of {of}", "parameter": moment, "value": gap[moment], "unit": gap["unit"]})
        columns = [*effects.index.names, *effects.columns]
        table = pd.DataFrame(rows, columns=columns).set_index(list(effects.index.names))
        table.attrs.update(verdict=self.verdict, sentence=self.sentence)
        return table

    @property
    def alternatives(self) -> pd.DataFrame:
        """Other explanations with their evidence, the runner-up first; empty where there are none."""
        rows = self.data.get("alternatives", ())
        return pd.DataFrame([{**row, "ids": " + ".join(row["ids"])} for row in rows])

    def plot_fit(self, joint: int | None = None, *, run: str | None = None, ax: Axes | None = None) -> Axes:
        """Plot a run's measured position and its simulations before and after the search.

        Parameters
        ----------
        joint
            Number of the joint where several move together; None for the only one.
        run
            File (name) of the run; None for the first one that no fit saw.
        ax
            Axes to draw on; None for new ones.

        Returns
        -------
        Axes
            The axes, position in rad or m.

        Raises
        ------
        InputError
            Where there is no such joint or run, or the torque was searched.
        """
        curve = self._curve(joint, run)
        axes = axes_or_new(ax)
        with style():
            draw_motion(axes, curve)
            _label(axes, curve, f"position [{unit_for('rad', curve.run.prismatic)}]")
        return axes

    def plot_residuals(self, joint: int | None = None, *, run: str | None = None, ax: Axes | None = None) -> Axes:
        """Plot what the model misses before and after the search.

        Parameters
        ----------
        joint, run, ax
            As `plot_fit` takes them. Where the torque was searched, all held-out stretches are shown.

        Returns
        -------
        Axes
            Measured − simulated position of a run over time [mrad] or [mm]; where the torque was searched, the residual
            torque over position [mN m] or [mN]. From 1 on in rad, m, N m or N, a residual torque also where the drive's
            torque reaches 1 N m (1 N).

        Raises
        ------
        InputError
            Where there is no such joint or run.
        """
        drawn = self._drawing_of_finding()
        if drawn.torque_left is not None:
            axes = axes_or_new(ax)
            with style():
                draw_torque_left(axes, drawn.torque_left, drawn.prismatic)
                axes.legend()
            return axes
        curve = self._curve(joint, run)
        axes = axes_or_new(ax)
        with style():
            unit, factor = residual_unit([curve])
            draw_residuals(axes, curve, factor)
            _label(axes, curve, f"measured − simulated [{unit}]")
        return axes

    def plot_where(self, variable: str = "position_rad", *, ax: Axes | None = None) -> Axes:
        """Plot over which part of a variable the nominal model misses the data.

        Parameters
        ----------
        variable
            ``position_rad``, ``velocity_rad_s``, ``torque_Nm``, ``time_s``, ``cycle``, ``direction``, ``run`` or
            ``frequency_rad_s``.
        ax
            Axes to draw on; None for new ones.

        Returns
        -------
        Axes
            Shares of the excess residual energy and of the samples [%].

        Raises
        ------
        InputError
            Where there is no such variable.
        """
        drawn = self._drawing_of_finding()
        maps = {m.variable: m for m in drawn.maps}
        if variable not in maps:
            expected = f"one of {', '.join(maps) or 'none: the whole device was only simulated'}"
            raise InputError("variable", expected=expected, got=repr(variable))
        axes = axes_or_new(ax)
        with style():
            draw_shares(axes, maps[variable], drawn.prismatic)
            axes.set_ylabel("share [%]")
            axes.legend()
        return axes

    def export_fmu(self, path: Path | str) -> Path:
        """Write the FMU of the joint with the named effects, in the packaging of the search.

        Parameters
        ----------
        path
            File to write.

        Returns
        -------
        Path
            ``path``.

        Raises
        ------
        InputError
            Where the verdict names nothing that goes into an FMU, or the place cannot be written.
        """
        made = self.data.get("fmu")
        if made is None:
            todo = "Identified.export_fmu writes the model without effects"
            raise InputError("export_fmu", expected="a verdict with named effects", got=self.verdict, todo=todo)
        target = Path(path)
        Place.of(target.parent).path.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.folder / made, target)
        return target

    def save(self, folder: Path | str) -> Missing:
        """Write everything that ``haptid missing`` writes: JSON, page, pictures and FMU.

        Parameters
        ----------
        folder
            Folder that may not exist yet; files of the same names are replaced.

        Returns
        -------
        Missing
            This result with ``folder`` as its folder. One that was read is copied as it is.

        Raises
        ------
        InputError, WritingError
            Where the folder cannot be written.
        """
        with errors_name_arguments(), lock_place(folder):
            saved = replace(self, place=self.place.copy_to(folder))
            write_report(saved)
            return saved

    def __str__(self) -> str:
        """Return verdict and gaps as ``haptid missing`` prints them."""
        return text_of(self.told())

    def told(self) -> Told:
        """Tell what ``haptid missing`` tells at its end.

        Returns
        -------
        list
            Verdict and gaps; the verdict alone where a stored finding was read.
        """
        if self.finding is None:
            return [f"{self.title}: {self.verdict}. {self.sentence}"]
        left_out = [f"  {self.left_out}"] if self.left_out else []
        return [*tell_finding(self.finding, self.title, self.verdict), *left_out]

    def __repr__(self) -> str:
        """Return what was searched, and the verdict, in a line."""
        return f"Missing({self.title}: {self.verdict})"

    def _repr_html_(self) -> str:
        """Return verdict, effects and gap for a notebook."""
        tables = {"effects": self.effects, "gap": self.gap, "alternatives": self.alternatives}
        shown = {caption: table for caption, table in tables.items() if len(table)}
        return html_of(
            f"{self.title.capitalize()}: {self.verdict.replace('_', ' ')}",
            " ".join(filter(None, (self.sentence, self.remark, self.left_out))),
            shown,
            measured=bool(self.data["measured"]),
        )

    def _drawing_of_finding(self) -> Drawn:
        """Return what figures are drawn from: of the search, or as it was stored."""
        if self.finding is None:
            return Drawn.read(self.file.with_suffix(SUFFIX))
        return Drawn.of(self.finding)

    def _curve(self, joint: int | None, run: str | None) -> Curve:
        drawn = self._drawing_of_finding()
        if not drawn.curves:
            got = "a check of the whole device" if drawn.torque_left is None else "a search of its torque"
            raise InputError("plot", expected="a search in the position of a joint", got=got)
        joints = sorted({joint for curve in drawn.curves for joint in curve.run.free_joints})
        number = only_one(joint, joints)
        curves = [curve for curve in drawn.curves if curve.run.free_joints == (number,)]
        chosen = [curve for curve in curves if run in (None, curve.run.file)]
        if not chosen:
            files = ", ".join(curve.run.file for curve in curves)
            raise InputError("run", expected=f"a run of joint {number} ({files})", got=repr(run))
        return chosen[0]


def _label(axes: Axes, curve: Curve, quantity: str) -> None:
    axes.set_title(f"{curve.run.file} ({curve.run.use})", fontsize=8)
    axes.set_xlabel("time [s]")
    axes.set_ylabel(quantity)
    axes.legend()


def write_report(made: Missing) -> None:
    """Write the page of a finding, and the pictures of a search in the position; one that was read has them.

    Parameters
    ----------
    made
        Result whose folder is written into.

    Raises
    ------
    WritingError
        Where the folder cannot be written.
    """
    if made.finding is None or made.values is None:
        return
    write_page(made.file.with_suffix(".html"), _page_of(made.finding, made.values))
    link_pages(made.folder)
    if isinstance(made.finding, Finding):
        write_pictures(made.finding, made.file.parent)


def _page_of(finding: AnyFinding, values: Values) -> Page:
    title, measured = values.title, values.measured
    if isinstance(finding, WholeFinding):
        return whole_gap_page(finding, title, measured=measured)
    if isinstance(finding, TorqueFinding):
        return torque_gap_page(finding, title, measured=measured)
    return discrepancy_page(finding, title, measured=measured)


def _file_of(folder: Path, joint: int | Sequence[int] | None) -> Path:
    """Return the file of a stored finding; without a joint the only one there."""
    found = findings_below(folder)
    if joint is not None:
        name = f"joint{joint}" if isinstance(joint, int) else f"joints{''.join(map(str, sorted(joint)))}"
    elif len(found) == 1:
        name = next(iter(found))
    else:
        name = ""
    if name not in found:
        told = ", ".join(found) or "none"
        where, got = str(folder / FINDINGS), "several" if len(found) > 1 and joint is None else name or "none"
        todo = "--joint chooses one" if found else word_origin("find_missing", "missing")
        raise InputError(where, expected=f"a finding, one of {told}", got=got, todo=todo)
    return found[name]


def _title_of(data: Mapping[str, Any], name: str) -> str:
    """Return what was searched, in words."""
    if name == WHOLE:
        return "all joints"
    joints = data.get("joints") or [data["joint"]]
    return f"joint{'s' * (len(joints) > 1)} {', '.join(map(str, joints))}"
