"""Thresholds of `discrepancy/unnamed/`: the missing torque as a function, and its formula."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class UnnamedThresholds:
    """Grids of the missing torque, and what is asked of its formula."""

    # Step 18: one variable or two.
    share_closed_by_one_variable: float = 0.9
    """Share of the excess RMS that one variable has to close to be enough [1]."""
    least_share_added_by_second_variable: float = 0.05
    """Further share that a second variable has to close [1]."""

    # Step 18: which variables.
    most_rows_of_rough_shape: int = 5_000
    """Number of fitted rows [1] up to which each shape is tried with all of them: of more, several are merged into one
    until the likeliest shape is known, which is then fitted to all."""

    # Step 18: the spline over one variable.
    spline_intervals: int = 7
    """Number of stretches of the variable, each with a cubic of its own."""
    curve_points: int = 15
    """Number of values of the variable at which the torque is returned."""

    # Step 18: the surface over two variables.
    surface_order: int = 4
    """Highest order of the polynomials of each variable."""
    surface_points_per_variable: int = 9
    """Number of values of each variable at which the torque is returned."""
    width_over_largest_speed: float = 0.1
    """Width b of the coordinate of a speed, as a share of the largest speed [1]."""

    # A formula for the curve.
    most_terms_of_formula: int = 2
    """Largest number of functions in a suggested formula."""
    least_p_value_of_formula: float = 0.01
    """p-value of χ² below which the terms do not follow the torque [1]."""
    least_std_over_largest_torque: float = 0.01
    """Least standard error of the torque that is assumed, as a share of the largest torque [1]."""
    least_chi2_gain_of_formula: float = 25.0
    """Least decrease of χ² that the terms must bring over no term at all [1]."""
