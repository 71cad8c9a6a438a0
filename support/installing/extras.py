"""Parts of the project that few need: what they require is asked for where it is first used."""

from __future__ import annotations

from functools import cache

from haptid.support.errors import InputError
from haptid.support.installing.environment import in_clone, missing
from haptid.support.installing.lock_file import amount


def need(extra: str, where: str) -> None:
    """Refuse in one line, with the command that installs it, what needs an extra that is not installed.

    Parameters
    ----------
    extra
        Name in pyproject.toml: ``cluster``, ``parquet`` or ``posterior``.
    where
        The file or option that needs it.

    Raises
    ------
    InputError
        Where a requirement of the extra is not met.
    """
    names = _lacking(extra)
    if names:
        todo = f"run `make {extra}` ({amount(extra)})" if in_clone() else f"run `pip install 'haptid[{extra}]'`"
        raise InputError(where, expected=f"an environment with the extra '{extra}'", got=f"no {names}", todo=todo)


@cache
def _lacking(extra: str) -> str:
    return ", ".join(requirement.name for requirement in missing(extra=extra))
