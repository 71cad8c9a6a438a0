"""What ``--map`` states of a column."""

from __future__ import annotations

import math

import pytest

from haptid.measurement.naming.map_option import parse_map
from haptid.measurement.naming.mapping import Target
from haptid.support.errors import InputError


@pytest.mark.parametrize(
    ("entry", "name", "factor"),
    [
        ("a=position_2_deg", "position_2_rad", math.pi / 180),
        ("a=torque_1_mNm", "torque_1_Nm", 1e-3),
        ("t=time_ms", "time_s", 1e-3),
        ("a=position_0_deg*0.02", "position_0_rad", 0.02 * math.pi / 180),
        ("a=b=position_0_rad*2*pi/4096", "position_0_rad", 2 * math.pi / 4096),
    ],
)
def test_a_name_may_have_another_unit_than_the_format(entry: str, name: str, factor: float):
    (target,) = parse_map((entry,)).values()
    assert target == Target(name=name, factor=pytest.approx(factor))


@pytest.mark.parametrize("entry", ["a=position_0_counts", "a=position_0", "a=speed", "=position_0_deg", "a"])
def test_a_name_without_a_known_unit_is_refused(entry: str):
    with pytest.raises(InputError, match="--map: expected COLUMN=NAME"):
        parse_map((entry,))
