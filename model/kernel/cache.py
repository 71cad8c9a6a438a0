"""A disk cache of compiled kernels: neither SymPy nor the compiler runs twice for the same equations.

`Equations` come in, `CompiledKernel` goes out. A record is keyed by the digest of the formulas and of the generator, so
that joints whose equations differ in their numbers alone share their kernels, those with an effect too.
"""

from __future__ import annotations

import hashlib
import json
from functools import cache
from importlib import resources
from pathlib import Path

from haptid.model.equations.equations import Equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.kernel.generate import Kernel
from haptid.model.thresholds import THRESHOLDS
from haptid.support.files.cache import cache_folder, is_sealed, machine, seal
from haptid.support.files.files import write_json


@cache
def generator() -> str:
    """Compute the digest of what the records depend on beside the equations.

    It changes with the generator's files, the machine and `THRESHOLDS`. Records of another digest are ignored.

    Returns
    -------
    str
        Sixteen hex digits.
    """
    found = hashlib.sha256(f"{machine()} {THRESHOLDS}".encode())
    for part in sorted(resources.files("haptid.model.kernel").iterdir(), key=lambda p: p.name):
        if part.name.endswith((".py", ".c", ".h")):
            found.update(part.read_bytes())
    return found.hexdigest()[:16]


def cached_kernel(
    equations: Equations,
    *,
    many: bool = True,
    tangent: bool = True,
    starts: tuple[int, ...] | None = None,
    substeps: int | None = None,
    step: float = THRESHOLDS.inner_step_s,
) -> CompiledKernel:
    """Return the compiled kernel of equations, from disk where it was compiled before.

    Parameters
    ----------
    equations
        Equations of the kernel.
    many
        Whether the kernel has to simulate many parameter sets side by side.
    tangent
        Whether the kernel needs sensitivities; a kernel that is not for many sets always has them.
    starts
        Indices of the states by whose initial values sensitivities are taken; all where None.
    substeps
        Largest number of sub-steps of an inner step; the kernel's default where None.
    step
        Longest inner step [s].

    Returns
    -------
    CompiledKernel
        The kernel; it may have lanes or sensitivities beyond the request.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    # a kernel with both, lanes and sensitivities, serves every request and is looked up first
    about = f"{substeps or 'default'}-{step!r}"
    if starts is not None and len(starts) < len(equations.states):
        about += f"-{'.'.join(map(str, starts))}"
    both = cache_folder("kernels") / f"{equations.formula_digest}-{generator()}-{about}.json"
    own = both.with_name(f"{both.stem}-{'one' if not many else 'flat'}.json")
    known = _load_record(equations, both, step) or (None if many and tangent else _load_record(equations, own, step))
    if known is not None:
        return known
    made = CompiledKernel.of(
        equations, many=many, substeps=substeps, tangent=tangent or not many, starts=starts, step=step
    )
    seal(
        write_json(
            both if many and tangent else own,
            {"library": made.path.name, "digest": made.kernel.digest, "columns": list(made.kernel.columns)},
        )
    )
    return made


def _load_record(equations: Equations, record: Path, step: float) -> CompiledKernel | None:
    """Return the kernel of a record, None where the record or its library is missing."""
    if not is_sealed(record):
        return None
    known = json.loads(record.read_text(encoding="utf-8"))
    library = cache_folder("compiled") / known["library"]
    if not is_sealed(library):
        return None
    columns = tuple(known["columns"])
    kernel = Kernel(equations=equations, source="", digest=known["digest"], columns=columns, step=step)
    return CompiledKernel(kernel, library)
