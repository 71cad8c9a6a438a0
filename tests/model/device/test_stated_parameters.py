"""Stated parameters that no fit could use, or that contradict each other, are refused with their place."""

import pytest

from haptid.model.device.stated_parameters import ROWS, check_parameters, range_of, with_positive_bound
from haptid.support.errors import InputError


def place(name):
    return f"a.toml, line 7, parameters.{name}"


@pytest.mark.parametrize(
    "stated",
    [
        {"inertia": {"initial": 2.2e-4, "lower": 2e-5, "upper": 2e-3}},
        {"Ks": {"initial": 0.01, "prior": {"mean": 0.01, "std": 0.002}}, "Kp": {"fixed": 1.0}},
        {"Ks": {"fixed": 0.0}, "epos": {"fixed": 0.0}},
        {"inertia": {"initial": 400.0}},
        {"sigma0": {"initial": 1.0, "lower": float("-inf"), "upper": float("inf")}},
        {"Fs": {"initial": 0.6}, "Fc": {"initial": 0.5}},
        {"Fs": {"fixed": 0.5}, "Fc": {"fixed": 0.5}},
        {"epos": {"initial": 0.1, "std": 1e-6}},
        {"sigma2": {"lower": 0}, "Fc": {"lower": 0.0, "upper": 1e-8}},
    ],
)
def test_what_can_be_is_taken(stated):
    check_parameters(stated, place)


@pytest.mark.parametrize("name", ROWS)
def test_default_values_are_taken(name):
    row = ROWS[name]
    check_parameters({name: {"initial": row.initial, "lower": row.lower, "upper": row.upper}}, place)
    assert range_of(name, {"initial": row.initial}) == (row.lower, row.upper)


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ({"inertia": {}}, "inertia: expected initial, bounds, a prior or a fixed value, got an empty table"),
        ({"inertia": {"initial": 1e-3, "fixed": 2e-3}}, "expected fixed alone, got fixed with initial; keep one"),
        (
            {"inertia": {"fixed": -1.0}},
            "from 1e-10 to 100000 (inertia at the joint in the posture of the test, SI units)",
        ),
        ({"Kp": {"fixed": 0.0}}, "got 0; it must be positive"),
        ({"Kp": {"fixed": 1e300}}, "got 1e+300; check its unit"),
        ({"epos": {"fixed": -1e300}}, "got -1e+300; check its unit"),
        ({"inertia": {"fixed": 1e-300}}, "got 1e-300; check its unit"),
        ({"Ks": {"initial": -1.0}}, "expected initial from 0 to"),
        ({"inertia": {"lower": -1e300, "upper": 1e300}}, "leave lower out if it is unknown"),
        ({"sigma2": {"lower": -1.0}}, "leave lower out if it is unknown"),
        ({"sigma2": {"lower": 0.0, "initial": 0.0}}, "got 0; it must be positive"),
        ({"sigma2": {"lower": 0.0, "upper": 0.0}}, "got 0; it must be positive"),
        ({"inertia": {"upper": -1.0}}, "expected upper from"),
        ({"inertia": {"upper": 1e-8}}, "expected lower < upper, got lower 1e-07, upper 1e-08; state both"),
        ({"inertia": {"lower": 1e-3, "upper": 1e-3}}, "fix it if it is known"),
        ({"inertia": {"initial": 1.0, "upper": 0.1}}, "initial 1 outside [1e-07, 0.1]"),
        ({"Ks": {"prior": {"mean": 2.0, "std": 0.1}, "upper": 1.0}}, "a prior's mean within the bounds"),
        ({"inertia": {"prior": {"mean": 1e300, "std": 0.1}}}, "expected mean from"),
        ({"inertia": {"prior": {"mean": 1e-3, "std": 1e-300}}}, "write fixed for what is known"),
        ({"inertia": {"initial": 1e-3, "std": 1e300}}, "leave the prior out"),
        ({"Fs": {"fixed": 1e-3}, "Fc": {"fixed": 1.0}}, "Fs: expected Fs >= Fc (stiction, Coulomb friction)"),
        ({"Fs": {"fixed": 1e-3}, "Fc": {"initial": 1.0}}, "got Fs = 0.001, Fc = 1"),
        ({"Fs": {"upper": 1e-3}, "Fc": {"lower": 1.0}}, "got Fs up to 0.001, Fc from 1"),
    ],
)
def test_what_cannot_be_is_refused(stated, words):
    with pytest.raises(InputError) as caught:
        check_parameters(stated, place)
    assert str(caught.value).startswith("a.toml, line 7, parameters.")
    assert words in str(caught.value)
    assert len(str(caught.value)) <= 293


@pytest.mark.parametrize(
    ("entry", "bounds"),
    [
        ({"lower": 0}, (1e-8, 1e3)),
        ({"lower": 0.0, "initial": 1e-9, "upper": 0.1}, (1e-9, 0.1)),
        ({"lower": 0.0, "upper": 1e-9}, (1e-11, 1e-9)),
    ],
)
def test_a_lower_bound_of_zero_says_positive_and_no_more(entry, bounds):
    assert range_of("sigma2", entry) == pytest.approx(bounds)
    assert with_positive_bound("sigma2", entry)["lower"] == pytest.approx(bounds[0])
    assert with_positive_bound("Ks", {"lower": 0.0}) == {"lower": 0.0}
