"""The friction laws by name: one file per law, found in this folder; no law is registered by hand."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path

from haptid.model.friction.law import FrictionLaw
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

DEFAULT = "lugre"
"""Friction law of a joint whose device file names none."""
MISSING = "friction_law"
"""Id under which a search names a law that a joint follows in the place of the one it was asked for; the variant says
which."""


@cache
def laws() -> dict[str, FrictionLaw]:
    """Find all friction laws of the folder.

    Returns
    -------
    dict
        Laws by id, in alphabetical order of their files.
    """
    modules = (importlib.import_module(f"{__package__}.{p.stem}") for p in sorted(Path(__file__).parent.glob("*.py")))
    found = (getattr(module, "LAW", None) for module in modules if module.__name__ != __name__)
    return {law.id: law for law in found if law is not None}


def law_named(id: str, where: str = "friction") -> FrictionLaw:
    """Return the friction law with this id.

    Parameters
    ----------
    id
        Id of the law, as ``lugre``.
    where
        Place that names the law, for messages.

    Returns
    -------
    FrictionLaw
        The law.

    Raises
    ------
    InputError
        Where there is no such law; the message lists the existing ones.
    """
    known = laws()
    if id not in known:
        todo = did_you_mean(id, tuple(known))
        raise InputError(where, expected=f"a friction law ({', '.join(known)})", got=repr(id), todo=todo)
    return known[id]
