"""FMUs that are built once and kept in the cache: `Equations` in, `Fmu` out.

The key of an entry holds everything that its archive is made from: the formulas, what the FMU shows of them, and the
source of this package and of the model. A change of any of them builds the FMU anew.
"""

from __future__ import annotations

import hashlib
from dataclasses import fields
from importlib.metadata import version
from pathlib import Path

from pythonfmu.builder import FmuBuilder

from haptid import fmu_build, model
from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.model.equations.equations import Equations
from haptid.model.thresholds import THRESHOLDS
from haptid.support import numbers
from haptid.support.files.cache import cache_folder, is_sealed, seal

GUESSED = ("initial", "lower", "upper", "std", "fixed", "prior", "guess")
"""Fields of a parameter that a fit sets in an identification FMU, and that its key leaves out: one FMU serves all."""

SOURCES = (".py", ".c", ".h", ".j2", ".txt", ".toml")
"""Suffixes of the files that an archive is made from."""


def builder_digest() -> str:
    """Return a digest of the code that turns equations into an FMU.

    It covers pythonfmu's version, this package, the whole model, whose formulas of friction and names of parameters the
    page of an FMU shows, and how numbers are written.

    Returns
    -------
    str
        Sixteen hex digits.
    """
    digest = hashlib.sha256(f"pythonfmu {version('pythonfmu')}".encode())
    for path in digested_files():
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def digested_files() -> list[Path]:
    """Return the files of the code that turns equations into an FMU.

    Returns
    -------
    list of Path
        Sources and templates of this package and of the model, and `support.numbers`, in a fixed order.
    """
    folders = [Path(package.__path__[0]) for package in (fmu_build, model)]
    found = [path for folder in folders for path in sorted(folder.rglob("*")) if path.suffix in SOURCES]
    return [*found, Path(numbers.__file__)]


def description_digest(equations: Equations) -> str:
    """Return a digest of everything in the equations that an FMU shows, first guesses and bounds included.

    Parameters
    ----------
    equations
        Equations of the FMU.

    Returns
    -------
    str
        Sixteen hex digits.
    """
    shown = (equations.states, equations.inputs, equations.outputs, equations.parameters, equations.title)
    told = (equations.orderings, equations.notes, equations.effects, equations.friction, equations.drive)
    return hashlib.sha256(repr((equations.digest, shown, told)).encode()).hexdigest()[:16]


def identification_fmu(equations: Equations, *, kind: Kind = "python") -> Fmu:
    """Return the identification FMU of some equations, from the cache or built for it.

    Parameters
    ----------
    equations
        Explicit equations, without observer; the FMU gets the observer as further inputs.
    kind
        Packaging; ``native`` in any case where pythonfmu has no loader for this machine.

    Returns
    -------
    Fmu
        With sensitivities. First guesses, bounds and priors are those of an earlier build, since a fit sets them.

    Raises
    ------
    InputError
        Where the reference run gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """
    if not FmuBuilder.has_binary():  # nothing for this platform among pythonfmu's loaders
        kind = "native"
    named = [tuple(getattr(q, f.name) for f in fields(q) if f.name not in GUESSED) for q in equations.parameters]
    shown = (equations.name, equations.title, equations.states, equations.inputs, equations.outputs, named)
    content = hashlib.sha256(repr((equations.digest, shown, equations.orderings)).encode()).hexdigest()[:16]
    return _find_or_build(equations, content, kind, identification=True)


def cached_fmu(equations: Equations, *, kind: Kind = "python", largest_torque: float = 0.0) -> Fmu:
    """Return the FMU of some equations at their first guesses, from the cache or built for it.

    Parameters
    ----------
    equations
        Equations of a joint, a configuration or a whole device.
    kind
        Packaging.
    largest_torque
        Largest torque that the drives apply [N m], which chooses the display unit; 0 where it is not known.

    Returns
    -------
    Fmu
        Without sensitivities, at a path in the cache.

    Raises
    ------
    InputError
        Where the reference run gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """
    content = description_digest(equations) + (f"_{largest_torque:g}" if largest_torque else "")
    return _find_or_build(equations, content, kind, identification=False, largest_torque=largest_torque)


def _find_or_build(
    equations: Equations, content: str, kind: Kind, *, identification: bool, largest_torque: float = 0.0
) -> Fmu:
    path = cache_folder("fmu") / f"{equations.name}_{content}_{builder_digest()}_{kind}{'_id' * identification}.fmu"
    if not is_sealed(path):
        made = build_fmu(equations, path, kind=kind, identification=identification, largest_torque=largest_torque)
        seal(path)
        return made
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    step = THRESHOLDS.inner_step_s
    return Fmu(path=path, digest=digest, equations=equations, kind=kind, step=step, identification=identification)
