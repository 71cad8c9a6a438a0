import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from haptid.measurement.format.reading import read_campaign
from haptid.measurement.making.writing import write_campaign
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.support.errors import InputError, one_line

NUMBERS = st.floats(-1e99, 1e99, allow_nan=False, width=64)
SMALL = st.floats(1e-9, 1e-1)


@st.composite
def runs(draw, file: str, use: str, joint: int) -> Run:
    n = draw(st.integers(8, 20))
    columns = arrays(np.float64, (n, 1), elements=NUMBERS)
    gaps = draw(arrays(np.float64, n - 1, elements=st.floats(1e-4, 10.0)))
    return Run(
        file=file + draw(st.sampled_from([".csv", ".csv.gz", ".parquet"])),
        free_joints=(joint,),
        t=np.concatenate([[0.0], np.cumsum(gaps)]),
        u=draw(columns),
        y=draw(columns),
        v=draw(st.none() | columns),
        noise=[draw(SMALL)],
        resolution=[draw(SMALL)],
        posture=[],
        use=use,
        hold=draw(st.sampled_from(["zero", "linear"])),
        reason="why not" if use == "excluded" else "",
        prismatic=(draw(st.booleans()),),
        extra={f"reference_{joint}_rad": draw(columns)[:, 0]} if draw(st.booleans()) else {},
    )


@st.composite
def campaigns(draw) -> Campaign:
    uses = ["fit", *draw(st.lists(st.sampled_from(["fit", "validate", "excluded"]), max_size=2))]
    joint = draw(st.integers(0, 30))
    return Campaign(
        folder=Path("unused"),
        title=draw(st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1).filter(str.strip)),
        device="single_joint",
        measured=draw(st.booleans()),
        hold=draw(st.sampled_from(["zero", "linear"])),
        runs=tuple(draw(runs(f"run{k}", use, joint)) for k, use in enumerate(uses)),
        parameter_overrides={joint: {"Fs": {"fixed": draw(st.floats(1e-6, 1e3))}}},
        friction=draw(st.sampled_from([{}, {joint: "lugre"}, {joint: "maxwell_slip"}])),
        extra={"source": {"licence": "none"}},
    )


@settings(max_examples=60, deadline=None)
@given(campaigns())
def test_what_is_written_is_read_back_bit_for_bit(campaign):
    with tempfile.TemporaryDirectory() as place:
        found = read_campaign(write_campaign(campaign, Path(place) / "c"))
    assert found.title == one_line(campaign.title)  # a title is read as one printable line
    for name in ("device", "measured", "hold", "parameter_overrides", "friction", "extra"):
        assert getattr(found, name) == getattr(campaign, name)
    for mine, theirs in zip(campaign.runs, found.runs, strict=True):
        for name in ("file", "free_joints", "use", "hold", "reason", "prismatic"):
            assert getattr(theirs, name) == getattr(mine, name)
        for name in ("t", "u", "y"):
            np.testing.assert_array_equal(getattr(theirs, name), getattr(mine, name))
        assert (mine.v is None) == (theirs.v is None)
        if mine.v is not None:
            np.testing.assert_array_equal(theirs.v, mine.v)
        assert set(theirs.extra) == set(mine.extra)
        for name, column in mine.extra.items():
            np.testing.assert_array_equal(theirs.extra[name], column)


def test_a_folder_with_content_is_not_overwritten(folder):
    campaign = read_campaign(folder.path)
    before = folder.toml.read_bytes()
    with pytest.raises(InputError, match="new or empty folder"):
        write_campaign(campaign, folder.path)
    assert folder.toml.read_bytes() == before


def test_gzipped_tables_are_reproducible(folder, tmp_path):
    campaign = read_campaign(folder.path)
    packed = campaign.but(runs=tuple(run.but(file=f"{run.file}.gz") for run in campaign.runs))
    written = [write_campaign(packed, tmp_path / name) / "a.csv.gz" for name in ("one", "two")]
    assert written[0].read_bytes() == written[1].read_bytes()
