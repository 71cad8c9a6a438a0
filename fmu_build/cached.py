"""FMUs for the fits, built once per set of equations and kept in the cache."""

from __future__ import annotations

import hashlib
from pathlib import Path

import fmu_build
from fmu_build.build import Fmu, Kind, build_fmu
from model.equations import Equations
from model.kernel.generate import DEFAULT_STEP, template
from support.files import cache_folder

_TEMPLATES = ("real.h", "weights.h", "stepper.h", "interface.c", "generate.py", "printing.py")


def builder_digest() -> str:
    """Return a digest of everything that turns equations into an FMU."""
    digest = hashlib.sha256()
    here = Path(fmu_build.__file__).parent
    for path in sorted((*here.glob("*.py"), *here.glob("*.c"), *here.glob("*.h"))):
        digest.update(path.read_bytes())
    for name in _TEMPLATES:
        digest.update(template(name).encode())
    return digest.hexdigest()[:16]


def description_digest(equations: Equations) -> str:
    """Return a digest of everything in the equations that an FMU shows, first guesses and bounds included."""
    shown = (equations.states, equations.inputs, equations.outputs, equations.parameters, equations.title)
    return hashlib.sha256(repr((equations.digest, shown, equations.orderings)).encode()).hexdigest()[:16]


def identification_fmu(equations: Equations, *, kind: Kind = "python") -> Fmu:
    """Return the identification FMU of ``equations`` from the cache, built where it is not there yet."""
    key = f"{equations.digest}_{builder_digest()}_{kind}"
    path = cache_folder("fmu") / f"{equations.name}_{key}.fmu"
    if not path.exists():
        return build_fmu(equations, path, kind=kind, identification=True)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    return Fmu(path=path, digest=digest, equations=equations, kind=kind, step=DEFAULT_STEP, identification=True)
