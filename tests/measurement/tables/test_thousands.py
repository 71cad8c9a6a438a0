"""A sign between thousands is no decimal sign, and three decimals are no thousands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from haptid.measurement.making.logged_table import read_logged_table
from haptid.measurement.tables.table import Table
from haptid.measurement.tables.thousands import refuse_thousands
from haptid.support.errors import InputError

COUNTS = np.round(4000 * np.sin(0.1 * np.arange(400))).astype(int)


def written(folder: Path, word: Callable[[int], str]) -> Table:
    cells = [word(int(count)) for count in COUNTS]
    frame = pd.DataFrame({"time_s": 0.004 * np.arange(COUNTS.size), "torque_Nm": 0.25, "encoder_counts": cells})
    frame.to_csv(folder / "a.csv", index=False, sep=";")
    return read_logged_table(folder / "a.csv")[0]


@pytest.mark.parametrize("sign", [".", ","])
def test_counts_with_a_sign_between_thousands_are_refused(tmp_path: Path, sign: str):
    """They made 0.19 rad of 5.85, without a word."""
    with pytest.raises(InputError, match=r"counts: expected numbers, got .* beside .*; export it without a sign"):
        refuse_thousands(written(tmp_path, lambda count: f"{count:,}".replace(",", sign)))


@pytest.mark.parametrize("word", [str, lambda count: f"{1e-3 * count:.3f}", lambda count: f"{1e-3 * count:.4g}"])
def test_whole_numbers_and_decimals_are_left(tmp_path: Path, word: Callable[[int], str]):
    refuse_thousands(written(tmp_path, word))
