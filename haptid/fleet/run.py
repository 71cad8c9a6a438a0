"""``haptid fleet FOLDERS``: every device identified by a command of its own, then their parameters compared."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import click

from haptid.fleet.campaigns import campaigns_in, digest_of
from haptid.fleet.comparison import compare
from haptid.fleet.page import fleet_page
from haptid.fleet.result import Identified, device_json, fleet_json, members_csv
from haptid.identification.sequence.resume import code_digest
from haptid.report.common.stored_page import write_page
from haptid.support.command import parse_joints
from haptid.support.declaring.declaration import IncompleteError
from haptid.support.errors import InputError, one_line
from haptid.support.files.files import check_writable, read_json, write_json, write_text
from haptid.support.files.folder_lock import lock_folder
from haptid.support.processes.running import Running
from haptid.support.terminal import Count

STAMP = "fleet_inputs.json"
"""File beside a device's results with the digest of what they were made from."""


def identify_fleet(
    folders: Sequence[Path], out: Path, workers: int, joints: str | None, seed: int, quiet: bool
) -> dict[str, Any]:
    """Identify all devices, and write and tell how they compare.

    Parameters
    ----------
    folders
        Campaigns, or folders of campaigns.
    out
        Folder of the results.
    workers
        Devices that are identified at the same time.
    joints
        Numbers of the joints, separated by commas; None for all.
    seed
        Seed of every fit.
    quiet
        Whether no progress is shown.

    Returns
    -------
    dict
        Content of fleet.json.

    Raises
    ------
    InputError
        Where a folder holds no campaign.
    IncompleteError
        Where a device could not be identified, after all others were.
    """
    campaigns = campaigns_in(folders)
    parse_joints(joints)  # refused here, and not once a device
    check_writable(out)
    options = {"seed": seed, "joints": joints}
    with lock_folder(out):
        ended = _identify_all(campaigns, out, options, workers, quiet)
        results = {one.name: _read_result(one.folder) for one in ended if not one.error}
        comparisons = compare(results)
        devices = [device_json(one, results.get(one.name)) for one in ended]
        data = fleet_json(devices, comparisons)
        write_json(out / "fleet.json", data)
        write_text(out / "fleet.csv", members_csv(comparisons))
        write_page(out / "fleet.html", fleet_page(devices, comparisons, data["sentence"]))
    for device in devices:
        told = device["error"] or f"worst unseen run {_over_noise(device['worst_over_noise'])}"
        click.echo(f"{device['name']}: {device['outcome']}; {told}")
    click.echo(f"{data['sentence']}\nwritten below {out}: fleet.json, fleet.csv, fleet.html")
    failed = [device["name"] for device in devices if device["error"]]
    if failed:
        sentence = f"haptid fleet: {len(failed)} of {len(devices)} devices were not identified: {', '.join(failed)}"
        raise IncompleteError(sentence, data)
    return data


def _over_noise(worst: float | None) -> str:
    return "is absent" if worst is None else f"{worst:.3g} × noise"


def _identify_all(
    campaigns: Mapping[str, Path], out: Path, options: Mapping[str, Any], workers: int, quiet: bool
) -> list[Identified]:
    """Identify the devices, several at a time; whatever ends this command ends those that run."""
    running = Running()
    ended: dict[str, Identified] = {}
    with Count[None](total=len(campaigns), title="devices", quiet=quiet) as bar, ThreadPoolExecutor(workers) as pool:
        try:
            jobs = [pool.submit(_identify, running, name, path, out, options) for name, path in campaigns.items()]
            for job in as_completed(jobs):
                one = job.result()
                ended[one.name] = one
                bar.update(figures=one.name)
        except BaseException:
            running.end()
            raise
    return [ended[name] for name in campaigns]


def _identify(running: Running, name: str, campaign: Path, out: Path, options: Mapping[str, Any]) -> Identified:
    """Identify one device in a process of its own, unless its results are there already."""
    folder, begin = out / "devices" / name, time.perf_counter()
    digest = digest_of(campaign, options, code_digest())
    if _is_done(folder, digest):
        return Identified(name=name, campaign=campaign, folder=folder, error="", kept=True, wall_s=0.0)
    command = [sys.executable, "-m", "haptid", "identify", str(campaign.absolute()), "--out", str(folder.absolute())]
    command += ["--workers", "1", "--quiet", "--seed", str(options["seed"])]
    command += ["--joints", options["joints"]] if options["joints"] else []
    # The clone's root, or the place of the installed package: the child finds the haptid that this is.
    source = Path(__file__).resolve().parents[2]
    paths = os.pathsep.join([str(source), *filter(None, [os.environ.get("PYTHONPATH")])])
    code, said = running.run(command, cwd=Path.cwd(), env=os.environ | {"PYTHONPATH": paths})
    error = ""
    if code != 0:
        lines = said.strip().splitlines() or [f"ended with code {code}"]
        error = one_line(lines[-1]).removeprefix("error: ")
    else:
        write_json(folder / STAMP, {"digest": digest})
    duration = time.perf_counter() - begin
    return Identified(name=name, campaign=campaign, folder=folder, error=error, kept=False, wall_s=duration)


def _is_done(folder: Path, digest: str) -> bool:
    """Whether complete results of the same inputs lie in ``folder``."""
    try:
        stamp = read_json(folder / STAMP, "the stamp of a fleet")
        result = _read_result(folder)
    except InputError:  # nothing there, or nothing that can be read: it is identified again
        return False
    return bool(stamp.get("digest") == digest and result.get("complete"))


def _read_result(folder: Path) -> dict[str, Any]:
    """Read an identification.json that was just written, of joints or of somebody else's FMU."""
    return read_json(folder / "identification.json", "an identification.json")
