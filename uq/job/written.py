"""Files of a sampled campaign: `Job` and `Sampled` joints in, chains, draws and ``posterior.json`` out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.fmu_build.accuracy.draws import digest_of
from haptid.fmu_build.accuracy.stored_draws import DRAWS_OF_POSTERIOR, POSTERIOR
from haptid.identification.sequence.resume import data_digest
from haptid.identification.verification.result import Verification
from haptid.support.files.files import write_json
from haptid.uq.job.job import Job
from haptid.uq.job.sample import Sampled
from haptid.uq.result.finite import with_null
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.record import SCHEMA, as_json, save_chains, save_draws


def chains_file(folder: Path, joint: int) -> Path:
    """Return the NetCDF file with the chains of a joint.

    Parameters
    ----------
    folder
        Folder of the results.
    joint
        Number of the joint.

    Returns
    -------
    Path
        Path, whether or not the file exists.
    """
    return folder / "posterior" / f"joint{joint}.nc"


def write_chains(job: Job, posterior: Posterior) -> Path:
    """Write the chains of a joint, which ArviZ reads.

    Parameters
    ----------
    job
        Job with the folder of the results.
    posterior
        Posterior of the joint.

    Returns
    -------
    Path
        File that was written.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    path = chains_file(job.out, posterior.joint)
    return save_chains(posterior, path, measured=job.campaign.measured)


def write_posteriors(job: Job, joints: Sequence[Sampled], full: Verification) -> dict[str, Any]:
    """Write draws and ``posterior.json`` of the joints that are finished so far.

    Parameters
    ----------
    job
        Job with the folder of the results.
    joints
        Finished joints.
    full
        Bands of runs with all joints free; without runs while joints are missing.

    Returns
    -------
    dict
        Content of ``posterior.json``.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    campaign, seed = job.campaign, job.options.sampling.seed
    head = {
        "schema": SCHEMA,
        "device": campaign.device,
        "campaign": campaign.title,
        "measured": campaign.measured,
        "seed": seed,
        "intervals": "equal-tailed",
    }
    posteriors = [one.posterior for one in joints]
    drawn = save_draws(posteriors, job.out / DRAWS_OF_POSTERIOR, np.random.default_rng([seed, 5]))
    entries = [as_json(one.posterior, data_digest(campaign, job.device, one.step.configuration)) for one in joints]
    draws = digest_of(drawn.read_bytes())
    data = with_null({**head, "draws": draws, "joints": entries, "full_model": full.as_json()})
    write_json(job.out / POSTERIOR, data)
    return data
