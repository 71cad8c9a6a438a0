"""Optional parts of the project, whose requirements are checked where a command first uses them."""

from __future__ import annotations

from functools import cache

from haptid.support.errors import InputError
from haptid.support.installing.environment import in_clone, missing
from haptid.support.installing.lock_file import amount


def need(extra: str, where: str) -> None:
    """Check that an extra is installed; the error gives the command that installs it.

    Parameters
    ----------
    extra
        Name in pyproject.toml: ``cluster``, ``matlab``, ``mcap``, ``parquet``, ``posterior`` or ``rosbags``.
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
