"""A chosen noise model on disk: a choice in, a file out and back, so that a stopped sampling does not choose again.

The choice may take longer than the chains. A file counts for the same runs, equations, start, options and code only.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from haptid.identification.sequence.resume import code_digest
from haptid.measurement.values.run import Array
from haptid.noise.noise_model import NoiseModel, Scatter
from haptid.support.files.files import write_bytes
from haptid.uq.density.forward import KernelForward
from haptid.uq.density.laplace import Laplace
from haptid.uq.prediction.choice import Problem, Scored

FILE = "noise_model.npz"
"""Name of the file in the folder of a joint's chains."""
TERMS = ("x0", "fixed", "start_shift", "correction")
"""What a run's likelihood is linearised about, by field of `Terms`."""


def digest_of_choice(problem: Problem, theta: Array, told: Sequence[object]) -> str:
    """Compute a digest of everything that a choice depends on.

    Parameters
    ----------
    problem
        Runs and equations, before an inner step is chosen.
    theta
        Start of the equations' parameters, shape (n_p,).
    told
        Further choices, whose ``repr`` counts.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256(code_digest() + _own_code())
    choices = (problem.noise_width, problem.widen, problem.climb, type(problem.forward).__name__, *told)
    # The digest of equations is that of their kernel: ranges and priors of the parameters are told beside it.
    digest.update(repr((problem.simulator.equations.digest, problem.simulator.equations.parameters, choices)).encode())
    digest.update(np.ascontiguousarray(theta).tobytes())
    for run in (*problem.fitted, *problem.unseen):
        digest.update(repr((run.file, run.use, run.hold, run.score_from, run.averaged_rows)).encode())
        for array in (run.t, run.u, run.inputs, run.y, run.v, run.noise, run.resolution):
            digest.update(b"" if array is None else array.tobytes())
    return digest.hexdigest()


@cache
def _own_code() -> bytes:
    """Return the digest of the code of noise models and densities."""
    digest, root = hashlib.sha256(), Path(__file__).parents[2]
    for package in ("noise", "uq"):
        for path in sorted((root / package).rglob("*")):
            if path.suffix in (".py", ".c"):
                digest.update(path.read_bytes())
    return digest.digest()


def write_choice(folder: Path, digest: str, problem: Problem, scored: Sequence[Scored], one: Scored) -> None:
    """Write a choice.

    Parameters
    ----------
    folder
        Folder of the joint's chains.
    digest
        Digest of what it depends on.
    problem
        Problem with the simulation under which it was made.
    scored, one
        Scored noise models, and the chosen one.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    forward = problem.forward
    content: dict[str, Any] = {
        "digest": digest,
        "step": forward.step if isinstance(forward, KernelForward) else np.nan,
        "models": [s.model.id for s in (one, *scored)],
        "scores": [s.score for s in (one, *scored)],
        "log_densities": [s.mode.log_density for s in (one, *scored)],
    }
    for number, entry in enumerate((one, *scored)):
        content |= {f"eta{number}": entry.mode.eta, f"covariance{number}": entry.mode.covariance}
    for number, terms in enumerate(one.mode.density.terms):
        content |= {f"{name}{number}": getattr(terms, name) for name in TERMS}
    stream = io.BytesIO()
    np.savez(stream, **content)
    write_bytes(folder / FILE, stream.getvalue())


def read_choice(
    folder: Path, digest: str, with_step: Callable[[float | None], Problem]
) -> tuple[Problem, tuple[Scored, ...], Scored] | None:
    """Read a choice that `write_choice` wrote.

    Parameters
    ----------
    folder
        Folder of the joint's chains.
    digest
        Digest of what the choice depends on.
    with_step
        Returns the problem with an inner step [s]; None is that of a simulation whose step cannot be chosen.

    Returns
    -------
    problem, scored, one : tuple or None
        As `write_choice` took them, but only the terms of the chosen noise model are linearised; None where there is no
        file, where it is damaged, or where the choice depended on something else.
    """
    try:
        with np.load(io.BytesIO((folder / FILE).read_bytes()), allow_pickle=False) as file:
            kept = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None
    if str(kept.get("digest")) != digest:
        return None
    step = float(kept["step"])
    problem = with_step(step if np.isfinite(step) else None)
    entries = []
    for number, name in enumerate(map(str, kept["models"])):
        model = _model_named(name)
        mode = Laplace(
            eta=kept[f"eta{number}"], covariance=kept[f"covariance{number}"], density=problem.density(model),
            log_density=float(kept["log_densities"][number]),
        )  # fmt: skip
        entries.append(Scored(model=model, mode=mode, score=float(kept["scores"][number])))
    one, *scored = entries
    density = one.mode.density
    terms = tuple(t.but(**{name: kept[f"{name}{k}"] for name in TERMS}) for k, t in enumerate(density.terms))
    return problem, tuple(scored), replace(one, mode=replace(one.mode, density=density.but(terms=terms)))


def _model_named(id: str) -> NoiseModel:
    """Return the noise model of a short name, as `NoiseModel.id` gives it."""
    scatter, *more = id.split("+")
    scatters: dict[str, Scatter] = {"none": "none", "reading": "reading", "torque": "torque"}
    return NoiseModel(scatter=scatters[scatter], runs="runs" in more, correlated="correlated" in more)
