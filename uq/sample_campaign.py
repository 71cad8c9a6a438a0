"""Sample the posterior of every joint's parameters: folder of a campaign in, posteriors and their report out."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from haptid.api.place import Place
from haptid.api.posteriors import sample_values
from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.workers.chosen_workers import workers_of
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.reading import is_foreign
from haptid.report.common.stored_page import write_page
from haptid.report.posterior.foreign_page import foreign_posterior_page
from haptid.support.command import listening, parse_joints, word_command
from haptid.support.errors import InputError
from haptid.support.files.files import write_json
from haptid.support.processes.threads import single_threaded
from haptid.support.terminal import show
from haptid.uq.foreign.infer import QUICK as FOREIGN_QUICK
from haptid.uq.foreign.infer import SAMPLING as FOREIGN_SAMPLING
from haptid.uq.foreign.infer import infer as infer_foreign
from haptid.uq.foreign.record import posterior_json
from haptid.uq.foreign.record import save_chains as save_foreign_chains
from haptid.uq.foreign.record import save_draws as save_foreign_draws
from haptid.uq.foreign.record import tell_summary as summary_of_foreign
from haptid.uq.foreign.source import holds_calibration, read_calibrated
from haptid.uq.result.finite import with_null


def sample_campaign(campaign: Path | None, **settings: Any) -> dict[str, Any]:
    """Sample the posterior of every joint, and write and tell the result.

    Parameters
    ----------
    campaign
        Folder with campaign.toml; None for the embedded Freedom 6S campaign.
    settings
        Options of the command by name.

    Returns
    -------
    dict
        Content of posterior.json.
    """
    if holds_calibration(campaign) or is_foreign(campaign):
        return _infer_foreign(campaign, **settings)
    read = campaign_for_command(campaign)
    with listening(quiet=settings["quiet"]) as listener:
        made = sample_values(
            read,
            Place(settings["out"]),
            listener,
            joints=parse_joints(settings["joints"]),
            quick=settings["quick"],
            sensitivity=settings["sensitivity"],
            kind=None if settings["kind"] == "none" else settings["kind"],
            seed=settings["seed"],
            workers=settings["workers"],
            scheduler=settings["scheduler"],
            made_by=word_command("posterior", "uq.run"),
        )
    return made.data


def _infer_foreign(campaign: Path | None, **settings: Any) -> dict[str, Any]:
    """Sample the posterior of a calibrated FMU: CAMPAIGN is the folder of its results, or --out holds them."""
    if settings["joints"] is not None:
        raise InputError("--joints", expected="no such option for an FMU", got=repr(settings["joints"]))
    folder = campaign if campaign is not None and holds_calibration(campaign) else settings["out"]
    chosen = click.get_current_context().get_parameter_source("out") is not ParameterSource.DEFAULT
    out, seed = settings["out"] if chosen else folder, settings["seed"]
    calibrated = read_calibrated(folder)
    options = replace(FOREIGN_QUICK if settings["quick"] else FOREIGN_SAMPLING, seed=seed)
    with (
        ForeignFmu(calibrated.campaign.model, limit_s=settings["limit_s"]) as fmu,
        workers_of(settings["scheduler"], settings["workers"]) as pool,
        listening(quiet=settings["quiet"]) as listener,
    ):
        listener.progress(fmu.path.name, 0, 1)

        def tell(share: float | None, figures: str) -> None:
            # Without a share no end is foretold: the time left would only grow.
            listener.progress(fmu.path.name, share or 0.0, None if share is None else 1, figures)

        posterior = single_threaded(infer_foreign, calibrated, fmu, options, pool, tell)
    data = with_null(posterior_json(posterior, seed))
    write_json(out / "posterior.json", data)
    save_foreign_draws(posterior, out / "parameters_posterior.csv", seed)
    save_foreign_chains(posterior, out / "posterior" / "model.nc")
    made_by = f"{word_command('posterior', 'uq.run')}, seed {seed}, {time.strftime('%Y-%m-%d')}"
    write_page(out / "posterior.html", foreign_posterior_page(posterior, [made_by, calibrated.campaign.title]))
    show(summary_of_foreign(posterior))
    return data
