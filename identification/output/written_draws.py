"""Draws of the identified parameters as files: `Step`s and `Whole` in, ``draws/<model>.csv`` and their digests out.

Every FMU that is exported from the results carries the draws of its model.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.fmu_build.accuracy.draws import COUNT, digest_of, draws_text
from haptid.fmu_build.accuracy.stored_draws import file_of
from haptid.identification.sequence.step import Step
from haptid.identification.sequence.whole_device import Whole
from haptid.identification.statistics.parameter_draws import draw_free
from haptid.measurement.values.run import Array
from haptid.support.files.files import write_text

OF_FIT = "covariance of the fit, in the coordinates in which it moved; orderings as Fs >= Fc are kept"
OF_LINKS = (
    "links by hit-and-run over physically consistent ones; springs and friction by the fits' covariance given them"
)


def write_draws(
    steps: Sequence[Step], whole: Whole | None, folder: Path, *, name: str, seed: int
) -> dict[str, dict[str, Any]]:
    """Write the draws of every joint that was tested alone, and of the whole device.

    Parameters
    ----------
    steps
        Fitted configurations; of several postures of a joint the first counts, as in its FMU.
    whole
        Parameters of the whole device with their draws; None where it was not identified.
    folder
        Folder of the results.
    name
        Name of the whole device's equations.
    seed
        Seed of the draws.

    Returns
    -------
    dict
        Entry ``{digest, source, seed, count}`` by name of the model, for identification.json.

    Raises
    ------
    InputError, WritingError
        As `write_text`.
    """
    told = {}
    for step in steps:
        joints = step.configuration.free_joints
        model = f"joint{joints[0]}"
        if len(joints) > 1 or model in told:
            continue
        fit = step.fit
        rng = np.random.default_rng([seed, 29, joints[0]])
        drawn = draw_free(fit.equations, fit.theta, fit.free, fit.covariance, count=COUNT, rng=rng)
        told[model] = _write(folder, model, fit.free, drawn, OF_FIT, seed)
    if whole is not None:
        ids = [id for id in whole.values if len({draw[id] for draw in whole.draws}) > 1]
        drawn = np.array([[draw[id] for id in ids] for draw in whole.draws])
        told[name] = _write(folder, name, ids, drawn, OF_LINKS, seed)
    return told


def _write(folder: Path, model: str, ids: Sequence[str], drawn: Array, source: str, seed: int) -> dict[str, Any]:
    text = draws_text(ids, drawn)
    write_text(file_of(folder, model), text)
    return {"digest": digest_of(text.encode()), "source": source, "seed": seed, "count": len(drawn)}
