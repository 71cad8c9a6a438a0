"""The friction laws by name: one file per law, found by looking into this folder."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path

from haptid.model.friction.law import FrictionLaw
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

DEFAULT = "lugre"
"""The law of a joint of which nothing is said."""


@cache
def laws() -> dict[str, FrictionLaw]:
    """Return every law by its id, in alphabetical order of the files."""
    modules = (importlib.import_module(f"{__package__}.{p.stem}") for p in sorted(Path(__file__).parent.glob("*.py")))
    found = (getattr(module, "LAW", None) for module in modules if module.__name__ != __name__)
    return {law.id: law for law in found if law is not None}


def law_named(id: str, where: str = "friction") -> FrictionLaw:
    """Return the law of this id.

    Raises
    ------
    InputError
        At ``where``, with the laws that exist.
    """
    known = laws()
    if id not in known:
        todo = did_you_mean(id, tuple(known))
        raise InputError(where, expected=f"a friction law ({', '.join(known)})", got=repr(id), todo=todo)
    return known[id]
