"""Optional parts of the project, whose requirements are checked where a command first uses them."""

from __future__ import annotations

import contextlib
import importlib
import io
import warnings
from collections.abc import Mapping
from functools import cache
from importlib import metadata

from haptid.support.errors import InputError
from haptid.support.installing.environment import in_clone, missing
from haptid.support.installing.lock_file import amount

MODULES: Mapping[str, tuple[str, ...]] = {
    "matlab": ("h5py",),
    "mcap": ("mcap.reader", "mcap_ros2.decoder"),
    "parquet": ("pyarrow.parquet",),
    "rosbags": ("lz4.frame", "rosbags.highlevel"),
}
"""Modules of the extras that read files: a library that is installed and broken is no damaged file."""


def need(extra: str, where: str) -> None:
    """Check that an extra is installed, and that what reads files can be imported; the error gives the remedy.

    Parameters
    ----------
    extra
        Name in pyproject.toml: ``cluster``, ``matlab``, ``mcap``, ``parquet``, ``posterior`` or ``rosbags``.
    where
        The file or option that needs it.

    Raises
    ------
    InputError
        Where a requirement of the extra is not met, or the import of a reader's library fails, with its reason.
    """
    names = _lacking(extra)
    if names:
        todo = f"run `make {extra}` ({amount(extra)})" if in_clone() else f"run `pip install 'haptid[{extra}]'`"
        raise InputError(where, expected=f"an environment with the extra '{extra}'", got=f"no {names}", todo=todo)
    for module in MODULES.get(extra, ()):
        _import(module, where)


def _import(module: str, where: str) -> None:
    try:
        # Some print their own lines on a failure, beside the one of the error.
        with warnings.catch_warnings(), contextlib.redirect_stderr(io.StringIO()):
            warnings.simplefilter("ignore")
            importlib.import_module(module)
    except Exception as error:  # whatever the library's own code raises
        raise cannot_be_imported(module, where, error) from None


def cannot_be_imported(module: str, where: str, error: Exception) -> InputError:
    """Return the error of a library that is installed and cannot be imported.

    Parameters
    ----------
    module
        Module that was imported, as ``mcap.reader``.
    where
        The file or option that needs it.
    error
        What its import raised.

    Returns
    -------
    InputError
        For the caller to raise.
    """
    library = module.partition(".")[0]
    names = metadata.packages_distributions().get(library, [library])
    got = f"an import that fails with {type(error).__name__}: {error}"
    todo = f"install it again: pip install --force-reinstall {names[0]}"
    return InputError(where, expected=f"a library {library} that can be imported", got=got, todo=todo)


@cache
def _lacking(extra: str) -> str:
    return ", ".join(requirement.name for requirement in missing(extra=extra))
