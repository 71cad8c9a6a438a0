"""What ``--map`` states of a column."""

from __future__ import annotations

import math
import re

import pytest

from haptid.measurement.naming.map_option import parse_map, remarks_on_grad, remarks_on_units
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


@pytest.mark.parametrize(
    "entry",
    ["u (V)=voltage_0_V", "u (V)=torque_0_Nm*0.05", "angle (deg)=position_0_deg", "u=torque_0_Nm", "w (x)=supply_V"],
)
def test_a_unit_that_agrees_or_has_a_factor_is_taken_without_a_word(entry: str):
    assert remarks_on_units(parse_map((entry,))) == []


@pytest.mark.parametrize(
    ("entry", "unit"),
    [("u (V)=torque_0_Nm", "V"), ("angle (deg)=position_0_rad", "deg"), ("I [mA]=current_0_A", "mA")],
)
def test_another_unit_without_a_factor_is_remarked_on(entry: str, unit: str):
    (remark,) = remarks_on_units(parse_map((entry,)))
    assert f"its name says {unit}: state the factor" in remark


def test_grad_in_small_letters_is_taken_for_degrees_with_a_remark():
    columns = {name: Target(name="position_0_rad", factor=math.pi / 180) for name in ("Winkel (Grad)", "winkel_grad")}
    (remark,) = remarks_on_grad(columns, ())
    assert remark.startswith("'winkel_grad' is taken in degrees: state gon (400 a turn) by --map 'winkel_grad=")
    assert remarks_on_grad(columns, columns) == []
    (stated,) = parse_map((re.search(r"--map '([^']+)'", remark)[1],)).values()
    assert stated.factor == pytest.approx(math.pi / 200)
