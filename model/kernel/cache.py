"""Compiled kernels found again on disk by the digest of their equations: neither SymPy nor the compiler runs twice."""

from __future__ import annotations

import hashlib
import json
from functools import cache
from importlib import resources
from pathlib import Path

from haptid.model.equations.equations import Equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.kernel.generate import Kernel
from haptid.support.files.cache import cache_folder, is_sealed, machine, seal
from haptid.support.files.files import write_json

SUBSTEPS = 8
"""Most sub-steps of a step: a trial that asks for more has contacts that are rigid at the pace of the readings."""


@cache
def generator() -> str:
    """Return a digest of the generator's code and of the machine: a kernel of another one is not taken."""
    found = hashlib.sha256(f"{machine()} {SUBSTEPS}".encode())
    for part in sorted(resources.files("haptid.model.kernel").iterdir(), key=lambda p: p.name):
        if part.name.endswith((".py", ".c", ".h")):
            found.update(part.read_bytes())
    return found.hexdigest()[:16]


def cached_kernel(equations: Equations, *, many: bool, tangent: bool = True) -> CompiledKernel:
    """Return the kernel of ``equations``, from disk where it was compiled before; it runs ``many`` sets if asked.

    One of many sets may do without sensitivities (``tangent``); one that has both serves all.
    """
    both = cache_folder("kernels") / f"{equations.digest}-{generator()}.json"
    own = both.with_name(f"{both.stem}-{'one' if not many else 'flat'}.json")
    known = _load_record(equations, both) or (None if many and tangent else _load_record(equations, own))
    if known is not None:
        return known
    made = CompiledKernel.of(equations, many=many, substeps=SUBSTEPS, tangent=tangent or not many)
    seal(
        write_json(
            both if many and tangent else own,
            {"library": made.path.name, "digest": made.kernel.digest, "columns": list(made.kernel.columns)},
        )
    )
    return made


def _load_record(equations: Equations, record: Path) -> CompiledKernel | None:
    """Return the kernel that a record tells of, None where it or its library is gone."""
    if not is_sealed(record):
        return None
    known = json.loads(record.read_text(encoding="utf-8"))
    library = cache_folder("compiled") / known["library"]
    if not is_sealed(library):
        return None
    kernel = Kernel(equations=equations, source="", digest=known["digest"], columns=tuple(known["columns"]))
    return CompiledKernel(kernel, library)
