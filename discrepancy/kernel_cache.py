"""Compiled kernels found again on disk by the digest of their equations: neither SymPy nor the compiler runs twice."""

from __future__ import annotations

import hashlib
import json
import platform
from functools import cache
from importlib import resources
from pathlib import Path

from model.equations import Equations
from model.kernel.compiled import CompiledKernel
from model.kernel.generate import Kernel
from support.files import cache_folder, write_json

SUBSTEPS = 8
"""Most sub-steps of a step: a trial that asks for more has contacts that are rigid at the pace of the readings."""


@cache
def generator() -> str:
    """Return a digest of the generator's code and of the machine: a kernel of another one is not taken."""
    found = hashlib.sha256(f"{platform.platform()} {SUBSTEPS}".encode())
    for part in sorted(resources.files("model.kernel").iterdir(), key=lambda p: p.name):
        if part.name.endswith((".py", ".c", ".h")):
            found.update(part.read_bytes())
    return found.hexdigest()[:16]


def cached_kernel(equations: Equations, *, many: bool) -> CompiledKernel:
    """Return the kernel of ``equations``, from disk where it was compiled before; it runs ``many`` sets if asked."""
    record = cache_folder("kernels") / f"{equations.digest}-{generator()}.json"
    alone = record.with_name(f"{record.stem}-one.json")
    known = _recorded(equations, record) or (None if many else _recorded(equations, alone))
    if known is not None:
        return known
    made = CompiledKernel.of(equations, many=many, substeps=SUBSTEPS)
    write_json(
        record if many else alone,
        {"library": str(made.path), "digest": made.kernel.digest, "columns": list(made.kernel.columns)},
    )
    return made


def _recorded(equations: Equations, record: Path) -> CompiledKernel | None:
    """Return the kernel that a record tells of, None where it or its library is gone."""
    if not record.exists():
        return None
    known = json.loads(record.read_text(encoding="utf-8"))
    library = Path(known["library"])
    if not library.exists():
        return None
    kernel = Kernel(equations=equations, source="", digest=known["digest"], columns=tuple(known["columns"]))
    return CompiledKernel(kernel, library)
