"""A chunk is taken back only as it was written; a chain with a damaged one is the chain that would have been."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from haptid.uq.sampling.chunk import Chunk


def written(folder: Path) -> Path:
    random = np.random.default_rng(0)
    chunk = Chunk(
        chain=random.standard_normal((5, 4, 2)), log_prob=random.standard_normal((5, 4)), accepted=np.arange(4.0)
    )
    chunk.write(folder / "a.h5")
    return folder / "a.h5"


def test_what_is_whole_is_read(tmp_path: Path):
    assert Chunk.read(written(tmp_path)).chain.shape == (5, 4, 2)


def test_a_changed_number_is_noticed(tmp_path: Path):
    path = written(tmp_path)
    with h5py.File(path, "r+") as file:
        file["log_prob"][0, 0] += 1.0
    with pytest.raises(ValueError, match="damaged"):
        Chunk.read(path)


@pytest.mark.parametrize("length", [0, 100, 1000])
def test_a_truncated_file_is_noticed(length: int, tmp_path: Path):
    path = written(tmp_path)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(ValueError, match="damaged"):
        Chunk.read(path)
