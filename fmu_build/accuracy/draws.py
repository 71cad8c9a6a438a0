"""Draws of a model's parameters from their uncertainty: `Draws` in, CSV out, and back."""

from __future__ import annotations

import csv
import hashlib
import io
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from haptid.support.errors import InputError
from haptid.support.files.files import read_content

Array = NDArray[np.float64]
COUNT = 200
"""Draws that an FMU carries: quantiles of 95 % are then known to about a tenth of the standard deviation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Hold draws of the parameters of one model.

    Parameters
    ----------
    columns
        Ids of the parameters in the equations, or FMU variable names.
    values
        Values in SI units, shape (n_draws, n_columns).
    source
        What they were drawn from, in words.
    seed
        Seed of the random numbers; None where unknown.
    """

    columns: tuple[str, ...]
    values: Array
    source: str
    seed: int | None = None

    def keep(self, wanted: Collection[str]) -> Draws:
        """Return a copy with some of the columns, in their own order.

        Parameters
        ----------
        wanted
            Columns to keep; others are ignored.

        Returns
        -------
        Draws
            The same draws of these columns.
        """
        places = [k for k, column in enumerate(self.columns) if column in wanted]
        return Draws(
            columns=tuple(self.columns[k] for k in places),
            values=self.values[:, places],
            source=self.source,
            seed=self.seed,
        )


def draws_text(columns: Sequence[str], values: Array) -> str:
    """Write draws as CSV, a row a draw with its number; numbers keep their last bit.

    Parameters
    ----------
    columns
        Names of the parameters.
    values
        Draws, shape (n_draws, n_columns).

    Returns
    -------
    str
        Header ``draw,<columns>`` and one line a draw.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["draw", *columns])
    for k, row in enumerate(values):
        writer.writerow([k, *(repr(float(x)) for x in row)])
    return stream.getvalue()


def digest_of(text: bytes) -> str:
    """Return sixteen hex digits of the SHA-256 of a file's content.

    Parameters
    ----------
    text
        Content of the file.

    Returns
    -------
    str
        The first 16 of the 64 hexadecimal digits.
    """
    return hashlib.sha256(text).hexdigest()[:16]


def read_draws(path: Path, digest: str, *, source: str, seed: int | None) -> Draws:
    """Read draws that a command wrote.

    Parameters
    ----------
    path
        CSV file as `draws_text` writes it.
    digest
        Digest of its content that the results state (`digest_of`).
    source, seed
        What the results say of the draws.

    Returns
    -------
    Draws

    Raises
    ------
    InputError
        Where the file cannot be read, its content is another, or holds what is no finite number.
    """
    data = read_content(path, "draws of parameters")
    if digest_of(data) != digest:
        todo = "remove the file to export without draws, or make the results again"
        got = f"content of the digest {digest_of(data)}"
        raise InputError(str(path), expected=f"the digest {digest}, which the results state", got=got, todo=todo)
    header, *rows = csv.reader(io.StringIO(data.decode(errors="replace")))
    values = np.array([[_number(x, path) for x in row[1:]] for row in rows], dtype=np.float64)
    return Draws(columns=tuple(header[1:]), values=values.reshape(len(rows), -1), source=source, seed=seed)


def _number(text: str, path: Path) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(str(path), expected="finite numbers", got=repr(text))
    return value
