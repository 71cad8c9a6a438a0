"""The kernel's C source with the functions on a flat buffer behind it."""

from __future__ import annotations

from importlib import resources

from fmu_build.variables import block_offsets
from model.kernel.generate import Kernel


def text_of(name: str) -> str:
    """Return the text of a file of this package."""
    return resources.files("fmu_build").joinpath(name).read_text(encoding="utf-8")


def layout(kernel: Kernel) -> str:
    """Return the places of the blocks as C macros."""
    at = block_offsets(kernel)
    return "\n".join((*(f"#define HF_{k.upper()} {n}" for k, n in at.items()), f"#define HF_STEP {kernel.step!r}", ""))


def flat_source(kernel: Kernel) -> str:
    """Return the C source of the kernel with ``hf_step`` and ``hf_output``."""
    return "\n".join((kernel.source, layout(kernel), text_of("flat.c")))


def functions(kernel: Kernel) -> tuple[str, ...]:
    """Return the names of the functions on the flat buffer."""
    return ("hf_step", "hf_output", *(("hf_step_tangent", "hf_output_tangent") if kernel.columns else ()))
