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


@cache
def generator() -> str:
    """Return a digest of the generator's code and of the machine: a kernel of another one is not taken."""
    found = hashlib.sha256(platform.platform().encode())
    for part in sorted(resources.files("model.kernel").iterdir(), key=lambda p: p.name):
        if part.name.endswith((".py", ".c", ".h")):
            found.update(part.read_bytes())
    return found.hexdigest()[:16]


def cached_kernel(equations: Equations, *, many: bool = True) -> CompiledKernel:
    """Return the kernel of ``equations``, from disk where it was compiled before; ``many`` sets at once if asked."""
    names = [f"{equations.digest}-{generator()}{part}.json" for part in ("", *(() if many else ("-one",)))]
    record = cache_folder("kernels") / names[-1]
    for path in (record.with_name(name) for name in names):
        if path.exists():
            known = json.loads(path.read_text(encoding="utf-8"))
            library = Path(known["library"])
            if library.exists():
                kernel = Kernel(equations=equations, source="", digest=known["digest"], columns=tuple(known["columns"]))
                return CompiledKernel(kernel, library)
    made = CompiledKernel.of(equations, lanes=4 if many else 0)
    write_json(
        record,
        {"library": str(made.path), "digest": made.kernel.digest, "columns": list(made.kernel.columns)},
    )
    return made
