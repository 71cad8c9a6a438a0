"""Identify a device: folder of a campaign in; fits in locking order, coupled test, verification and export out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.api.identified import complete
from haptid.api.identify import identify_values
from haptid.api.place import Place
from haptid.fmu_build.exchange.ssv import write_ssv
from haptid.identification.calibration.calibrate import calibrate
from haptid.identification.calibration.result_json import calibration_json
from haptid.identification.calibration.start_values import write_with_starts
from haptid.identification.calibration.words import tell_summary as summary_of_calibration
from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.job.provenance import provenance, word_this_command
from haptid.identification.problem.options import FitOptions
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.foreign_campaign import read_foreign_campaign
from haptid.measurement.format.reading import is_foreign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.report.calibration.page import calibration_page
from haptid.report.common.stored_page import write_page
from haptid.report.identification.drawings import Drawings
from haptid.support.command import listening, parse_joints
from haptid.support.errors import InputError
from haptid.support.files.files import write_json
from haptid.support.terminal import show


def identify_campaign(  # noqa: PLR0913 # one argument an option
    campaign: Path | str | None,
    out: Path,
    joints: str | None,
    scheduler: str | None,
    *,
    kind: str,
    no_export: bool,
    model: Path | None,
    limit_s: float,
    **choices: Any,
) -> dict[str, Any]:
    """Identify a device from a campaign, and write and tell the result.

    Parameters
    ----------
    campaign
        Folder with campaign.toml; None for the embedded Freedom 6S campaign.
    out
        Folder of the results.
    joints
        Numbers of the joints, separated by commas; None for all.
    scheduler
        Address of a Dask scheduler; None runs here.
    kind
        Packaging that the fits run: ``python``, ``native`` or ``none``.
    no_export
        Whether the FMUs of the whole device are left out.
    model
        FMU to calibrate; None where the campaign does not name the variables of one, or names it itself.
    limit_s
        Longest wait for one simulation of an FMU [s].
    choices
        Fields of `FitOptions`.

    Returns
    -------
    dict
        Content of identification.json.

    Raises
    ------
    InputError
        Where the campaign, the options or the FMU are wrong, or an option is given that an FMU does not take.
    WritingError
        Where ``out`` cannot be written.
    """
    options = FitOptions(**choices)
    if model is not None or is_foreign(campaign):
        for name, value in (("--joints", joints), ("--scheduler", scheduler)):
            if value is not None:
                raise InputError(name, expected="no such option for an FMU", got=repr(value), todo="leave it out")
        return _calibrate(campaign, model, out, options, limit_s)
    read = campaign_for_command(campaign)
    with listening(quiet=options.quiet) as listener, Drawings(options.workers) as drawings:
        identified = identify_values(
            read,
            Place(out),
            listener,
            drawings,
            joints=parse_joints(joints),
            kind=None if kind == "none" else kind,  # type: ignore[arg-type] # click has checked the choice
            options=options,
            scheduler=scheduler,
            made_by=word_this_command(),
        )
        exported = complete(identified, listener, drawings, report=True, fmus=not no_export)
    show(identified.told())
    click.echo(f"written below {out}: identification.json, report.html" + "".join(f", {p.name}" for p in exported))
    return identified.data


def _calibrate(
    campaign: Path | str | None, model: Path | None, out: Path, options: FitOptions, limit_s: float
) -> dict[str, Any]:
    """Calibrate an FMU, write its results, and return the content of identification.json."""
    if campaign is None:
        raise InputError("CAMPAIGN", expected="the folder of a campaign about the FMU", got="none")
    with warnings_on_stderr():
        read = read_foreign_campaign(campaign, model)
    with ForeignFmu(read.model, limit_s=limit_s) as fmu, listening(quiet=options.quiet) as listener:
        listener.progress(read.model.name, 0, 1)

        def tell(share: float, figures: str) -> None:
            listener.progress(read.model.name, share, 1, figures)

        calibration = calibrate(read, fmu, options, tell)
    data = calibration_json(calibration, provenance(options, word_this_command()), out)
    write_json(out / "identification.json", data)
    write_page(out / "report.html", calibration_page(calibration, data))
    write_with_starts(read.model, out / "identified.fmu", calibration.values)
    # The units of an FMU may be no units of a parameter set: each value is in its variable's own.
    write_ssv(out / "parameters.ssv", calibration.values, dict.fromkeys(calibration.values, ""))
    show(summary_of_calibration(calibration))
    click.echo(f"written below {out}: identification.json, report.html, identified.fmu, parameters.ssv")
    return data
