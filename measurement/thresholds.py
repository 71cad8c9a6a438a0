"""Thresholds of measurement: what decides whether a campaign is read, what is remarked, and how it is split.

Lengths of lists and tolerances of arithmetic stand where they are used.

A number without a derivation in its docstring was chosen. What halving and doubling it changes in a panel of cases
stands in `docs/results/thresholds.md`. Positions, speeds and torques are those of rotary joints; a prismatic joint has
metres and newtons instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """Numbers that decide an outcome of measurement, each with its quantity and unit."""

    # Positions that a recorder averaged over rows.
    most_averaged_rows: int = 99
    """Largest stated number of rows of an average [1]."""
    least_rows_of_spectrum: int = 200
    """Fewest rows of a run whose spectrum is looked at [1]."""
    most_rows_of_spectrum: int = 4096
    """Rows of a run whose spectrum is looked at [1]: more tell nothing more."""
    most_spectra_of_averaging: int = 6
    """Number of spectra, one for each run and joint, that are looked at [1]."""
    largest_spread_of_even_rows: float = 0.01
    """Largest spread of row intervals over their median up to which rows count as even [1]."""
    least_frequency_of_averaging_per_row: float = 0.1
    """Frequency [1/row] from which on the spectrum is looked at: below it are the motion and slow errors."""
    floor_of_notch: float = 1e-3
    """What rounding to a step leaves in a notch of an average's spectrum, over its level beside [1]."""
    least_lead_of_average_per_spectrum: float = 10.0
    """Log likelihood by which the spectrum of an average must be ahead of a smooth one, for each run and joint
    [1]: a factor of 2·10⁴."""

    # Noise beside motion.
    least_noise_in_higher_order: float = 0.8
    """Least standard deviation that differences of the highest order leave, over that of order 4, from which on both
    are noise [1]: noise leaves 0.9 to 1.1 on the recorders seen, motion of ten rows a period and fewer up to 0.5."""
    stray_contrast_in_std: float = 3.0
    """Magnitude of a divided difference over the noise [1] beyond which it counts as stray and not as noise."""
    least_noise_over_range: float = 1e-9
    """Least noise over the range of the readings [1]: readings without noise are not infinitely exact."""

    least_rows_of_noise_estimate: int = 40
    """Fewest rows, each k-th of a run, from which noise behind a filter is read [1]; all k phases are looked at."""
    least_rise_behind_filter: float = 1.6
    """Rise of the differences from neighbouring rows to every second row from which the readings were low-pass filtered
    [1]: behind an edge of second order it is 4 and more, behind one of first order, which is correlated noise, 1.41."""
    growth_of_stride: float = 1.2
    """Factor from one k to the next [1]: between the edge of a filter and the motion there may be half an octave."""
    largest_noise_behind_filter_over_range: float = 0.01
    """Share of the travel above which what rows far apart differ by is motion [1]."""

    # Tables: what is read of a file.
    longest_interval_at_counter_wrap: float = 10.0
    """Longest interval across the wrap of a time's counter over the median interval [1]: a time that falls by another
    amount is an error of the log."""
    least_rows_of_table: int = 8
    """Rows of the shortest table that is read [1]."""
    least_cells_of_thousands: int = 60
    """Cells with three digits behind their one point, none with one or two, and none below 1, beside whole numbers
    below 1000, from which on the points stand between thousands [1]: of decimals whose last zeros are left out one
    cell in ten has fewer."""
    largest_reading: float = 1e100
    """Largest time, torque, position or velocity that is read, in any unit: squares of such numbers are finite."""
    most_lines_of_layout: int = 200
    """Number of lines from the start whose layout is checked [1]: a layout is the same throughout a file."""
    longest_line_characters: int = 1_000_000
    """Characters of a line that are read [1], so that a file without line breaks does not fill the memory."""
    largest_unpacked_bytes: int = 64 << 20
    """Size [B] that a table may unpack to in any case."""
    largest_unpacked_over_packed: int = 250
    """Size over the size of its file [1] that a larger table may unpack to. Measured tables pack to between a third and
    a twentieth of their size; a larger ratio is made to fill the memory."""

    # Rows of a logger's table that make no run.
    largest_share_of_rows_left_out: float = 0.2
    """Share of a table's rows that may be left out for empty cells or repeated times [1]; beyond it the table is of
    another kind, as signals of two rates in one table, and is refused."""
    longest_gap_in_run_rows: float = 3.5
    """Longest time over the usual row interval [1] across which a run goes on where rows are missing: the torque of two
    missing rows is held, that of more is not known."""
    share_of_usual_intervals: float = 0.99
    """Share of the row intervals [1] up to whose length an interval is usual: a gap is longer by the factor above.
    Where rows come at irregular times, every hundredth interval is so long that no gap shows beside it."""
    least_rows_of_part: int = 50
    """Fewest rows of a part between two gaps that becomes a run [1], as many as show the noise."""
    least_share_of_part: float = 0.02
    """Share of its table's rows [1] below which a part between two gaps is too short to show anything."""
    largest_step_at_wrap: float = 3.0
    """Largest motion in the row in which a counter wraps, over that of the fastest other row [1]."""

    # Keys of campaign.toml: ranges beyond any device.
    smallest_noise_or_step: float = 1e-15
    """Smallest noise or step of a position sensor [rad]."""
    largest_noise_or_step: float = 1e3
    """Largest noise or step of a position sensor [rad]."""
    smallest_torque_per_ampere: float = 1e-9
    """Smallest torque constant of a drive [N m/A]."""
    largest_torque_per_ampere: float = 1e9
    """Largest torque constant of a drive [N m/A]."""
    largest_locked_position: float = 1e4
    """Largest position of a locked joint [rad]."""

    # Postures of locked joints.
    largest_difference_of_one_posture: float = 5e-3
    """Difference of a held joint's positions in two runs of the same free joints [rad] up to which both have one
    posture: it changes a gravity torque by at most 0.5 % of its amplitude, covers encoders of 1250 counts a turn and
    locks that repeat within 0.3°, and postures that are chosen to tell coefficients apart lie tenths of a radian apart.
    A larger stated encoder step takes its place."""

    # Sizes of signals: beyond them a unit is wrong, and the run is refused.
    largest_torque: float = 1e12
    """Largest torque of a drive [N m]."""
    smallest_torque: float = 1e-15
    """Torque [N m] below which a run drives nothing that can be measured; a torque that is 0 throughout is no wrong
    unit."""
    largest_position: float = 1e9
    """Largest travel [rad]."""
    largest_speed: float = 1e9
    """Largest speed [rad/s]."""
    least_travel_over_noise: float = 10.0
    """Travel over the standard deviation of a reading [1], below which a joint counts as at rest."""
    least_travel_over_largest: float = 0.02
    """Travel over the largest one of the joints in the same table [1], below which a joint counts as locked when a
    campaign is made: a lock that gives way moves by less."""

    # Clock: the time between rows.
    shortest_row_interval_s: float = 1e-9
    """Least time between rows [s]: no joint is sampled faster."""
    longest_row_interval_s: float = 0.5
    """Median time between rows [s] above which a joint's friction can no longer be resolved."""
    shortest_likely_row_interval_s: float = 1e-4
    """Median time between rows [s] below which a time without a unit is not in seconds: joints are logged at 10 kHz at
    most, and hours or minutes are closer."""
    longest_usual_row_interval_s: float = 0.0501
    """Median time between rows [s] above which milliseconds are more likely; 20 Hz is a usual rate."""
    longest_gap_s: float = 10.0
    """A gap may last this long [s] in any case."""
    longest_gap_in_rows: float = 100.0
    """A longer gap may last as long as this many rows [1]."""
    largest_deviation_of_even_interval: float = 0.01
    """Deviation of a row interval from the median, over the median [1], up to which it counts as even."""

    # Remarks on units and signs of one joint.
    largest_travel_of_revolute_joint_rad: float = 8.0 * math.pi
    """Travel of a revolute joint [rad], four turns, above which degrees are more likely."""
    largest_travel_over_range: float = 1.5
    """Travel over the device's range of motion [1] above which degrees are more likely than an inexact range."""
    largest_torque_over_limit: float = 10.0
    """Torque over the device's limit [1] above which thousandths of the unit are more likely."""
    largest_torque_over_inertial_torque: float = 300.0
    """Torque over acceleration per stated inertia in a joint's fastest run [1], above which thousandths of the unit are
    likely. Friction and springs take most of the torque of slow runs, and in fast runs up to 20 times the inertial
    torque."""
    least_share_of_rows_at_largest_torque: float = 0.01
    """Share of the rows at the largest torque of either sign [1] from which it may be a limit."""
    least_limit_over_largest_torque: float = 0.5
    """Magnitude of the torque's other end over its largest one [1] from which it may be a limit, too: a torque that
    pushes one way rests at 0."""
    largest_rows_below_over_at_largest_torque: float = 1.0 / 3.0
    """Rows within three steps of the numbers below the largest torque over those at it [1], up to which it is no peak:
    a smooth one has as many."""
    least_share_of_rows_between_limits: float = 0.2
    """Share of the rows at no limit and not at 0 [1] below which the torque is a square wave or made of pulses."""
    largest_share_at_rest_between_limits: float = 0.2
    """Share of those rows in which the torque rests half as long as at its limits [1], above which it is a
    staircase."""
    least_power_over_rms: float = -0.05
    """Mean power over RMS torque times RMS velocity [1], below which a joint would drive its motor."""
    least_gain_of_turned_torque: float = 0.5
    """What turning a run's torque round takes at least from the squares that a fit of the joint's runs leaves, over the
    run's own [1], where its sign is wrong. Turning a right run of a measured campaign adds 0.8 to 3 to them."""
    least_gain_of_turned_torque_in_good_fit: float = 0.05
    """The same where turning takes `least_share_of_turned_torque` of what the fit leaves [1]."""
    least_share_of_turned_torque: float = 0.9
    """Share of what the fit leaves [1] that turning a wrong run round takes where the fit is good afterwards: turning a
    right one out of such a fit leaves 30 to 1000 times as much."""
    least_squares_without_inertia_over_with: float = 2.0
    """Squares that a fit leaves without the acceleration over those with it [1], from which the sign of the inertia
    counts."""

    least_correlation_of_stated_controller: float = 0.9
    """Correlation of the stated controller's command with the recorded one [1], from which their sizes compare."""
    largest_factor_of_stated_controller: float = 1.25
    """Stated over recorded command, or the inverse [1], above which the gains are likely in another unit: at that
    correlation the noise of a differenced position makes up to a tenth."""
    largest_correlation_of_other_controller: float = 0.5
    """Correlation [1] below which another controller than the stated one made the command."""
    largest_difference_of_stated_controller: float = 0.1
    """RMS difference between the torque of a stated controller and the recorded one, over the latter [1], above which
    the recorded torque is taken: of a wrist with a filtered speed 0.3, of a knee 0.004."""
    least_share_left_by_noisy_torque: float = 2.0
    """Share of its energy that a rigid body leaves of the recorded torque, over that of the stated controller's [1],
    above which the recorded one is a noisy reading of the other."""
    largest_difference_from_torque_constant: float = 0.05
    """Relative difference [1] of that factor from one over the torque constant up to which the gains are in amperes."""
    margin_of_saturation: float = 1e-3
    """Distance of a command from its limit, over it [1], below which the command counts as saturated."""

    # Remarks on the position sensor.
    largest_stated_over_estimated_noise: float = 10.0
    """Ratio of stated to estimated noise [1], or the inverse, above which the two contradict each other."""
    least_differences_of_noise: int = 50
    """Fewest differences of readings, or rows, that show the noise [1]."""
    least_encoder_bits: int = 8
    """Fewest bits of an encoder [bits]."""
    most_encoder_bits: int = 26
    """Most bits of an encoder [bits]."""
    largest_distance_from_whole_bits: float = 1e-4
    """Largest distance of a number of counts from a power of two [bits]."""
    largest_ratio_of_equal_steps: float = 1.4
    """Ratio of the encoder's steps of two runs of a joint [1] up to which they are one step; an estimate is the step or
    a multiple or part of it."""
    largest_ratio_of_steps_between_runs: float = 3.0
    """Ratio of the encoder's steps of two runs of a joint [1] from which one of them is odd wherever
    its readings lie: an estimate may be twice the step where levels are missing."""
    largest_ratio_of_noise_between_runs: float = 10.0
    """Noise of a run, step included, over that of the joint's other runs [1] from which it is odd: where a motion is
    jerky, it comes out up to four times as large."""
    least_ratio_of_noise_between_repeats: float = 2.0
    """Spread between repeats of one torque over the noise, step included [1], from which the noise is correlated: white
    noise comes out within 10 %."""
    longest_correlation_of_noise_over_run: float = 0.02
    """Rows over which the spread between repeats is correlated, over those of the run [1], up to which it is noise: a
    motion that does not repeat is a spread of longer waves."""
    least_noise_over_step_of_flicker: float = 0.5
    """Noise over the encoder's step [1] from which readings at rest change level."""
    least_distance_from_level_in_steps: float = 0.1
    """Distance of an end from the nearest level [encoder steps] from which it lies between the levels."""
    least_rows_of_plateau: int = 5
    """Equal extreme readings in a row [1] from which a run looks clipped, if they are a large share of it, too."""
    least_share_of_rows_at_end: float = 0.02
    """Share of the run at that reading [1] from which the run looks clipped."""
    largest_share_of_marked_rows: float = 0.05
    """Share of a run's rows [1] up to which one number far from all others marks missing readings."""
    least_distance_of_mark_over_range: float = 10.0
    """Distance of such a number from all other readings over their range [1]."""

    # Remarks on pairs of runs.
    largest_relative_difference_of_copies: float = 1e-9
    """Relative difference [1] below which two numbers are one number that was written twice."""
    largest_relative_difference_of_named_frequency: float = 0.03
    """Relative difference [1] between a frequency and the number that names it: names are rounded."""

    # Position control: its signs in a run.
    least_share_of_steady_rows: float = 0.95
    """Share of moving rows at one speed [1], from which a motion counts as a prescribed sweep."""
    largest_noise_of_command_over_range: float = 3e-4
    """Noise of a torque relative to its range [1], below which the torque counts as an open-loop command."""
    least_noise_correlation_of_feedback: float = 0.3
    """Correlation of the torque's and the position's noise [1], from which the torque counts as fed back from the
    position."""
    longest_controller_delay_rows: int = 3
    """Longest delay of a controller that is looked for [rows]."""

    # Columns of a new campaign.
    largest_ratio_of_travels: float = 3.0
    """Travel of a demanded over that of a measured position [1], or the inverse, up to which both are in one unit."""

    # Cycles and harmonics of the torque.
    boundary_error_in_std: float = 5.0
    """Error of a cycle boundary over the standard error of its phase [1]."""
    least_boundary_error_cycles: float = 1e-6
    """Least error of a cycle boundary [cycles], however exact the torque is."""
    largest_boundary_error_cycles: float = 1e-4
    """Largest error of a cycle boundary [cycles], however noisy the torque is."""
    least_line_share_of_variance: float = 0.5
    """Least share of the torque's variance on one line [1] for a run to count as periodic."""
    least_line_share_of_two_cycles: float = 0.95
    """Least share of that variance [1] where a run has at most two cycles, so that a drift does not count as a
    cycle."""
    least_share_of_cycle: float = 0.1
    """Share of a cycle [1] below which a piece at either end of the run joins its neighbour."""
    highest_harmonic_rad_per_s: float = 40.0
    """Highest angular frequency of a harmonic [rad/s]."""
    most_harmonics: int = 24
    """Most harmonics of a run [1]."""

    # Preparation: held-out rows and smoothed motion.
    fitted_share_of_run: float = 2.0 / 3.0
    """Share of a run's duration that is fitted [1] where no run validates."""
    least_rows_of_split_run: int = 24
    """Rows of the shortest run that is split [1]."""
    smoothing_width_over_period: float = 1.0 / 60.0
    """Width of the Gaussian that smooths a motion, as a share of the motion's period [1]."""
    least_smoothing_width_rows: float = 2.0
    """Least width of a Gaussian that smooths or filters a motion [rows]: below it the derivatives of the sampled
    Gaussian are not exact."""
    largest_noise_share_of_acceleration: float = 0.005
    """Largest share of noise in the variance of the filtered acceleration [1]: as much as it biases the inertia."""
    largest_filter_width_over_period: float = 0.04
    """Largest width of the filter over the motion's dominant period [1]: it leaves 97 % of that motion."""
    growth_of_filter_width: float = 1.25
    """Ratio of successive widths that are tried [1]."""
    filter_reach_in_widths: float = 4.0
    """Length at either end of a run that the filter has no full surroundings for, over its width [1]."""

    # Repeats: what of a torque does not come back at the same position and speed.
    cells_of_position: int = 25
    """Number of cells of position in which passes are compared [1]."""
    cells_of_speed: int = 12
    """Number of cells of speed in which passes are compared [1]."""
    fineness_of_cells: tuple[int, ...] = (1, 2, 4, 8, 16)
    """Into how many each cell of position is cut [1]: the finest show a ripple of two hundred waves over the travel."""
    least_repeated_share_of_rows: float = 0.2
    """Share of the rows in cells with several passes [1], below which it is unknown what does not repeat."""


THRESHOLDS = Thresholds()
"""Thresholds that the code of `measurement/` uses."""
