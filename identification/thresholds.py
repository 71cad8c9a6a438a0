"""Thresholds of identification: every number that decides which strategy, start, status or outcome a fit has.

A number without a derivation in its docstring was chosen. What halving and doubling it changes in a panel of cases
stands in `docs/results/thresholds.md`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """Numbers that decide an outcome of identification, each with its quantity and unit."""

    # Strategy: whether a run is simulated freely or through an observer.
    largest_growth_of_start_error: float = 30.0
    """Growth of an error of the initial position over a run [1] above which a free simulation is not compared with the
    data."""
    observer_gain_over_motion_frequency: float = 3.0
    """Observer gain over the circular frequency of the fastest joint's strongest spectral line [1]."""
    least_observer_gain_per_s: float = 5.0
    """Smallest observer gain [1/s], however slow the motion is."""
    largest_observer_gain_per_s: float = 60.0
    """Largest observer gain [1/s], however fast the motion is."""
    most_starts_beside_plain_guess: int = 2
    """Largest number of starts of several joints whose first guesses are the plain model's [1]."""
    most_starts_of_trial: int = 2
    """Largest number of starts of the fit through an observer that decides whether the torque is fitted [1]."""
    observer_gains_beside_controller: tuple[float, ...] = (20.0, 6.0, 2.0, 0.0)
    """Observer gains [1/s] of a fit through the recorded controller: on a servo of low gain four of five starts without
    an observer ended up to a third above the cost that all starts with it share to 2 %."""
    most_starts_beside_controller: int = 3
    """Largest number of starts of a fit through the recorded controller [1]."""

    largest_lead_of_observer: float = 0.05
    """Difference of the mean logarithms of the errors of torque and position [1] up to which a fit of the torque and
    one through an observer count as equally good: 5 %."""

    # Encoder zeros: what each run's zero has to explain before readings are no longer taken for positions.
    encoder_zero_std_over_travel: float = 0.05
    """Standard deviation of the prior of a run's encoder zero over the travel of the joint [1]."""
    largest_encoder_zero_in_std: float = 5.0
    """Largest encoder zero over the standard deviation of its prior [1] that is taken for one: a quarter of the
    travel."""
    largest_residual_with_zeros_over_without: float = 2.0 / 3.0
    """Largest RMS residual with encoder zeros over the one without [1] at which they are taken. Whatever else is
    missing differs a little from run to run too, and must not be taken for a zero."""
    largest_residual_of_first_start_with_zeros: float = 0.85
    """The same of one start [1], from which several are made: other starts, and wider ranges, may leave less."""

    largest_stiction_over_coulomb: float = 3.0
    """Largest Fs over the first guess of Fc [1] in a fit of the torque, where the user states none."""
    stiction_prior_mean_over_coulomb: float = 1.2
    """Mean of the prior of Fs, and its first guess, over the first guess of Fc [1] in a fit of the torque."""
    stiction_prior_std_over_coulomb: float = 0.5
    """Standard deviation of the prior of Fs over the first guess of Fc [1] in a fit of the torque."""
    stribeck_speed_over_top_speed: float = 0.02
    """Mean and standard deviation of the prior of vs over the top speed [1] in a fit of the torque."""
    largest_stribeck_speed_over_top_speed: float = 0.05
    """Largest vs over the top speed [1] in a fit of the torque."""
    largest_free_residual_over_motion: float = 0.25
    """RMS error of a free simulation over the RMS of the motion about its mean [1], above which the position moves no
    estimate of the torque: the simulation has lost the motion, and its slopes tell nothing."""
    least_decrease_of_joint_cost: float = 0.01
    """Decrease of the cost that holds torque and position below which it is minimised [1]: a tenth of a standard error
    squared."""

    stribeck_speed_over_least_speed: float = 100.0
    """The same mean over the smallest vs [1]."""
    largest_share_left_by_release: float = 0.5
    """Mean square of the residual without the restraint of the Stribeck curve over that with it [1] below which the
    restraint is dropped above the noise as well: it was then what most of the residual came from."""
    most_reweighings: int = 8
    """Largest number of fits with a new weight of the rows near reversals [1]."""
    least_change_of_weight: float = 0.05
    """Share by which that weight has to change for another fit [1]."""

    # Plain model: rows, columns and blocks of its least squares, and how it is simulated.
    largest_rest_speed_over_rms_speed: float = 0.05
    """Speed over the RMS speed [1] up to which a joint counts as at rest: its friction then takes any value up to its
    level, and the row is left out."""
    step_of_friction_in_filter_widths: float = 2.0
    """Distance from a rest up to which a row does not count, and from a reversal up to which it names no effect, in
    widths of the filter [1]: a step of friction in the wrong place passes through it once, and 95 % of what is wrong
    lies within two widths."""
    least_rows_of_step: float = 8.0
    """The same in rows: what a torque does between two rows is known to 1 % of a step through a filter of two rows,
    which is what a motion begins with, and two passes of that filter spread it over eight."""
    least_rows_of_plain_model: int = 50
    """Fewest interior rows of all fitted runs together [1] for which the plain model is fitted."""
    least_new_part_of_column: float = 1e-3
    """Norm of a column's part that the earlier columns do not explain, over its own norm [1], below which the column
    is left out."""
    least_residual_torque_over_torque: float = 1e-9
    """RMS of a residual torque over that of all torques [1], below which it counts as that much: where columns explain
    a torque exactly, its weight stays finite."""
    block_of_residual_in_correlation_lengths: float = 5.0
    """Length of a block of the residual over its correlation length [1]."""
    least_residual_blocks_of_run: int = 8
    """Smallest number of blocks of a run [1]."""
    weighted_solutions: int = 3
    """Number of solutions [1], each with the weights of the residual before."""
    largest_delay_over_time_of_speed: float = 0.1
    """Largest delay of the torque that is looked for, over RMS speed over RMS acceleration [1]: a longer one would be a
    phase of the motion itself, which inertia, spring and viscous friction explain as well."""
    largest_delay_over_bracket: float = 0.95
    """Delay over the largest that is looked for [1] above which it stands for something else and is not taken."""
    bristles_beside_delay_over_travel: tuple[float, ...] = (0.001, 0.003, 0.01, 0.03, 0.1)
    """Travels of the bristles that a delay is estimated beside, over the travel of the joint [1]: friction that turns
    late looks like a torque that arrives late."""
    stribeck_beside_delay_over_speed: tuple[float, ...] = (0.02, 0.1)
    """Stribeck speeds of the friction that a delay is estimated beside, over the top speed [1]."""
    width_of_slower_delay_over_filter: float = 2.0
    """Width of one more filter, over that of the torques [1], behind which the delay is estimated again: it leaves the
    slower half of the band."""
    delays_of_scan: int = 21
    """Number of delays whose cost is compared before the best is refined [1]."""
    least_delay_in_standard_errors: float = 3.0
    """Least delay in its standard errors [1], as for the amplitude of an effect."""
    largest_distance_from_half_a_row: float = 0.1
    """Largest distance in rows [1] of a delay from −0.5 at which the torque counts as one that runs linearly between
    rows and was held: each held row stands for a time half a row later."""
    nearer_to_half_a_row: float = 0.25
    """Distance in rows [1] of a delay from −0.5, its standard error included, up to which the delay is smaller where
    the torque runs linearly between rows than where it is held."""
    least_gain_of_delay_in_standard_errors: float = 1.0
    """Least decrease of the energy of held-out blocks in its standard errors over the blocks [1], as for an effect."""
    presliding_of_plain_model_over_travel: float = 3e-4
    """Displacement at which the plain model's Coulomb friction is at its level, over the travel of the joint [1]."""
    least_friction_over_torque: float = 1e-6
    """Coulomb friction of the plain model over the largest torque [1], below which it is raised: no law divides by
    0."""
    soft_spring_torque_over_torque: float = 1e-4
    """Torque of the spring that carries a constant torque, over the travel, as a share of the largest torque [1]."""
    horizons_of_prediction_s: tuple[float, ...] = (0.1, 1.0, 10.0)
    """Lengths of the simulations from the measured state [s] by which both models are held against the motion."""
    longest_judged_horizon_s: float = 1.0
    """Longest horizon by which models are compared [s]: longer ones show drift alone."""
    most_simulations_of_horizon: int = 200
    """Largest number of simulations for one horizon [1]; they are spread over the run."""
    postures_of_mass_check: int = 200
    """Largest number of rows of a run at which the plain model's mass matrix has to be positive definite [1]."""

    # Starts: first guesses, their bounds and initial states.
    least_travel_for_gravity_rad: float = 1.2
    """Range of positions [rad] above which the first guess distinguishes gravity from a spring."""
    bounds_over_guess: float = 100.0
    """Factor [1] of a positive parameter's first guess to its bounds on either side."""
    least_friction_guess_over_torque: float = 1e-3
    """Least first guess of a joint's friction over its largest torque [1], where the plain model finds none."""
    most_widenings_of_bounds: int = 3
    """Largest number of times that ranges which haptid chose are widened [1]: three times a hundredfold."""
    largest_stiction_over_torque: float = 3.0
    """Stiction over the torque that command and gravity made together [1], beyond which its range is not widened: the
    joint moved, and springs and inertia added their part to that torque."""
    widening_of_linear_range: float = 4.0
    """Length by which a linear range is widened on the side of the estimate, over its length [1]."""
    starts_of_refit: int = 3
    """Number of starts of a fit within widened ranges [1], the first of them at the optimum before."""
    starts_over_guess: float = 2.0
    """Factor [1] of the first guess within which logarithmic parameters start; linear ones start within their typical
    size."""
    rows_of_initial_velocity: int = 9
    """Number of rows at the beginning of a run that the parabola of the initial velocity is fitted to [1]."""
    rows_of_velocity_guess: int = 5
    """Number of rows at the beginning of a run whose parabola gives the velocity from which a descent begins [1]."""
    least_initial_velocity_in_std: float = 6.0
    """Initial velocity over its standard deviation [1] above which a run counts as started in motion, so that its
    initial velocity is fitted."""

    start_rows_over_rows: float = 0.05
    """Share of the rows of an unseen run [1] that determine its initial state: the rest is a prediction."""
    least_start_rows: int = 50
    """Smallest number of rows of an unseen run [1] that determine its initial state: fifty readings of white noise give
    a position at rest to a seventh of that noise."""

    # Cost: what a row and its residual weigh.
    weights_of_run_halves: tuple[float, float] = (0.5, 1.0)
    """Weights [1] of the first and the second half of a run: the first has the transients. From Tam, Kubica and Wang
    (2005), equation 3."""
    turn_of_loss_in_std: float = 3.0
    """Residual in standard deviations of the noise [1] at which the loss turns from quadratic to linear."""

    most_simulations_of_initial_state: int = 20
    """Largest number of simulations that fit the initial state of an unseen run [1]."""
    cost_change_of_initial_state: float = 1e-9
    """Relative change of the cost below which the initial state of an unseen run is fitted [1]."""

    # Parametrisation: sizes of parameters whose range says little.
    largest_range_over_guess: float = 1e6
    """Width of a linear range over the first guess [1], above which the range is not the size of the quantity."""
    smallest_bound_over_guess: float = 1e-9
    """Lower bound of a logarithm over the first guess [1], where the bound of the quantity is 0 and has no
    logarithm."""

    # Minimisation: when a step, a descent and the search for starts end.
    tolerance_of_early_level: float = 1e-3
    """Relative decrease of the cost [1] below which a level of the homotopy before the last ends."""
    tolerance_of_last_level: float = 1e-5
    """The same for the last level [1]."""
    largest_residual_near_the_data: float = 3.0
    """Largest residual over the noise [1] from which the last level of the homotopy begins without those before it."""
    largest_residual_near_the_data_over_motion: float = 0.1
    """The same over the RMS of the motion [1]: where the noise is large, a joint at rest is within three of it."""
    tolerance_of_polish: float = 1e-8
    """The same for the polish [1]."""
    tolerance_of_polish_far: float = 1e-6
    """The same for the polish where the residual is a model error [1]: a few hundred independent parts of the motion
    determine the parameters, so that a decrease by 1e-6 moves them by a hundredth of their standard deviation."""
    most_iterations_of_early_level: int = 15
    """Largest number of iterations of a level before the last [1]."""
    most_iterations_of_last_level: int = 60
    """Largest number of iterations of the last level, and of the polish [1]."""
    least_damping_of_slsqp: float = 1e-3
    """Smallest λ that is added to SLSQP's first Hessian [1]."""
    least_damping: float = 1e-10
    """Smallest damping λ of Levenberg-Marquardt [1]: a direction that the data do not see at all does not make the
    step singular."""
    largest_damping: float = 1e9
    """Damping λ of Levenberg-Marquardt [1] above which the minimiser stops."""
    share_of_tolerance_for_unit_step: float = 1e-4
    """Share of the tolerance [1] that a step of length 1 costs in a descent. Far smaller, and rounding moves what
    no residual tells across its range, and with it what is named; at 0.01 valleys are left before their end."""
    longest_step_of_logarithm: float = 0.35
    """Longest step along the logarithm of a parameter [1] from every other start of a fit, a factor of √2: far from a
    minimum the slopes send what the residual hardly sees to the end of its range, where it sees nothing of it."""
    largest_room_at_limit: float = 1e-4
    """Distance of coordinates [1] up to which they have met a bound or an ordering."""
    places_beside_corner: int = 5
    """Number of values over its range [1] at which a parameter is placed that no residual sees where a limit is met."""
    most_corners_of_descent: int = 3
    """Largest number of corners that one minimisation is led out of [1]."""
    least_actual_over_predicted_decrease: float = 1e-4
    """Actual over predicted decrease of the cost [1] above which a step is accepted."""
    most_halvings_of_inner_step: int = 3
    """Largest number of times that the model's own inner step is halved for a result [1]."""
    most_halvings_of_whole_step: int = 7
    """The same for the whole device, whose joints move each other through friction that was rigid in each alone."""
    largest_inner_step_error_over_residual: float = 0.1
    """Largest error of the residual by an inner step, as a share of the residual's norm [1]: a coarser one than the
    model's own is used up to it, and a finer one above it."""
    largest_shift_by_inner_step: float = 0.5
    """Length of the change of all estimates by the inner step's error, in their standard deviations [1], above which a
    result has a finer one: on stiff friction and 4500 rows the step of the model moved an inertia by ten."""
    most_rows_of_homotopy: int = 12_000
    """Number of fitted rows [1] of which a descent needs no more before its polish: of twice as many, rows are
    merged."""
    excess_cost_at_full_tolerance: float = 1e4
    """Excess of the cost over one square a row [squares over the noise] from which the tolerance of a descent grows in
    proportion: a small decrease decides nothing where the residual is so far above the noise, and Gauss-Newton steps
    creep there."""
    excess_cost_of_model_error: float = 100.0
    """Cost per row [squares over the noise] above which the residual counts as a model error alone: ten times the noise
    in RMS."""
    most_simulations_without_progress: int = 10
    """Number of successive simulations [1] whose average decrease of the cost must reach the tolerance."""
    largest_cost_difference_in_basin: float = 2.0
    """Difference of costs [squares over the noise] up to which two starts share a minimum: far below a difference that
    distinguishes two models."""
    largest_relative_cost_difference_in_basin: float = 1e-3
    """The same as a share of the smaller cost [1]; the larger of both counts."""
    agreeing_starts_above_noise: int = 4
    """Number of starts [1] that must share the best minimum where it lies above the noise: there the residual cannot
    confirm that a minimum is the best."""

    # Outcome: in which words a fit ends.
    least_rows_per_parameter: int = 10
    """Readings of the fitted runs per fitted parameter [1], below which nothing is concluded from a residual."""
    largest_residual_over_motion: float = 0.5
    """RMS of the residual over the RMS of the motion about its mean [1], above which a model counts as explaining
    nothing."""
    largest_unseen_residual_over_tolerance: float = 1.2
    """Factor [1] on the tolerance for runs that no fit saw: a run's own noise varies about the pooled one."""

    standard_errors_of_residual: float = 3.0
    """Standard errors [1] by which the residual of a calibrated FMU may exceed its noise and still counts as noise:
    white noise alone is beyond in one fit of a thousand."""

    # Identifiability: the status of a parameter and what is told of combinations.
    largest_std_over_size: float = 0.5
    """Standard deviation over the parameter's size [1], up to which a parameter without a prior is identified."""
    smallest_felt_share: float = 0.02
    """Torque of one standard deviation over the largest torque [1], and standard deviation of a spring's equilibrium
    over the travel [1], up to which gravity and spring are identified whatever their value: what drives repeat."""
    standard_errors_of_interval: float = 1.96
    """Standard deviations from the estimate to the ends of a 95 % interval [1]."""
    largest_unseen_presliding: float = 0.1
    """Length of presliding over the standard deviation of the mean of all rows [1] below which it is not seen:
    reversals add up what each shifts, and a rigid joint is fitted with ever stiffer bristles."""
    largest_chi_squared_of_no_gravity: float = 5.99
    """Wald statistic of both gravity parameters [1] up to which no gravity is seen: 95 % of χ² with two degrees of
    freedom."""
    largest_std_over_prior_std: float = 0.5
    """Standard deviation over the prior's [1], above which the prior counts as what determines the parameter."""
    largest_bound_distance_over_range: float = 1e-4
    """Distance from a bound, as a share of the range [1], within which a parameter lies on it."""
    least_component_of_combination: float = 0.1
    """Smallest component of a unit eigenvector [1] that makes a parameter a member of a combination."""
    most_members_of_combination: int = 4
    """Largest number of members of a combination [1]: longer ones say nothing to a reader."""
    least_rows_of_friction_regime: int = 20
    """Number of rows in presliding, or in gross sliding [1], below which a warning is given."""

    # Profile likelihood: how far an end of an interval is followed.
    most_simulations_of_profile: int = 24
    """Largest number of simulations of all runs of a fit with one parameter held."""
    most_distances_of_profile: int = 10
    """Largest number of distances that are tried for each end of an interval [1]."""
    largest_error_of_root_rise: float = 0.01
    """Relative error of √(C − Ĉ) [1] below which the end of an interval is accepted: as much of its half width."""

    # Covariance: from which residuals and refits it is estimated.
    longest_lag_over_rows: float = 0.1
    """Longest lag of the autocovariance, as a share of the rows of the shortest run [1]."""
    least_jackknife_blocks: int = 6
    """Smallest number of blocks of the jackknife, of all runs together [1]."""
    most_simulations_of_refit: int = 12
    """Largest number of simulations of a refit of the jackknife [1]."""

    # Links and sequence: how tests are joined into one device.
    least_p_of_consistent_tests: float = 1e-3
    """Family-wise p-value (Bonferroni over one configuration's comparisons) [1] below which tests contradict each
    other."""
    least_eigenvalue_of_pseudo_inertia: float = 1e-5
    """Smallest eigenvalue of the scaled pseudo-inertia [1]: strictly physical, so that forward dynamics always
    exists."""
    widening_of_link_priors: float = 10.0
    """Factor [1] on the stated standard deviations of all link parameters with which the data must still halve that of
    one which counts as identified: otherwise the priors of the others told it."""
    steps_between_physical_draws: int = 300
    """Number of steps between draws of physical links [1]: several times the number of directions that the data do not
    identify."""
    chains_of_physical_draws: int = 20
    """Number of chains that draw physical links side by side [1]; each begins at the estimate."""
    least_information_over_prior: float = 1e-6
    """Smallest information of a measured coefficient, as a share of its prior's information [1]."""
    carried_std_over_belief_std: float = 3.0
    """Standard deviation of a carried prior over that of the belief [1]: tests on different days agree less well than
    their noise says."""
    draws_of_whole_device: int = 20
    """Number of draws of the full model's parameters [1] behind the spread of its verification."""
    most_rounds_of_draws: int = 50
    """Number of times that as many draws are made as are wanted [1]: enough where one in fifty meets the orderings."""

    # Summary and report: how a residual is told.
    largest_residual_as_noise: float = 1.05
    """RMS of the residual over the sensor's noise [1] up to which a run's residual counts as sensor noise."""
    largest_residual_over_expected: float = 2.0
    """RMS of the whole model's residual over √(noise² + spread²) [1] up to which noise and the parameters' uncertainty
    explain it: one draw of the parameters reaches it by chance, as |N(0, 1)| is below 2 in 95 % of cases."""
    largest_spread_in_noise: float = 10.0
    """Spread of the whole model's prediction over the sensor's noise [1] up to which it may explain a residual: a wider
    one would hide whatever the model lacks."""
    largest_residual_in_noise: float = 10.0
    """RMS of the residual over the sensor's noise [1] above which it is told as a quantity and a share of the motion as
    well: a number of hundreds says how fine the sensor is, not how good the model."""
    least_cycles_of_amplitude_scatter: int = 3
    """Smallest number of cycles of a run [1] whose amplitudes are told: fewer show no scatter."""
    least_rows_of_cycle_amplitude: int = 8
    """Smallest number of rows of a cycle [1] that has an amplitude of its own."""

    # Foreign FMUs: what an archive and its process may take.
    largest_spread_of_even_steps: float = 1e-3
    """Difference of the longest and the shortest step over the median [1], up to which rows are evenly spaced: times in
    a table are rounded."""
    largest_unpacked_bytes: int = 2_000_000_000
    """Largest size of an unpacked archive [B]."""
    most_archive_entries: int = 100_000
    """Largest number of entries of an archive [1]."""
    largest_description_bytes: int = 100_000_000
    """Largest size of a model description [B]."""
    largest_written_file_bytes: int = 100_000_000
    """Largest size of a file that an FMU may write [B]."""
    longest_simulation_s: float = 60.0
    """Longest wait for one simulation [s]."""
    longest_start_of_process_s: float = 120.0
    """Longest wait for a process to import this package [s], which takes long on a loaded machine."""
    relative_tolerance_of_exchange: float = 1e-8
    """Relative tolerance of the solver of a model that is exchanged [1]: its error is far below a difference quotient's
    change of the outputs."""
    largest_exchange_step_over_duration: float = 0.02
    """Longest step of that solver over the duration of the run [1]: no event of the model is stepped over."""
    most_exchange_steps_between_rows: int = 100_000
    """Largest number of that solver's steps between two rows [1]."""
    least_exchange_step_over_time: float = 1e-12
    """Distance between two times over the larger of them [1] up to which they are the same."""

    # Remarks on stated priors.
    largest_distance_from_prior_in_std: float = 3.0
    """Distance of an estimate from the mean of its prior over the standard deviation of that prior [1], up to which
    both agree: a normal prior that is right lies so near in 99.7 % of cases."""
    least_difference_from_device: float = 0.2
    """Difference of a fitted inertia from that of the device's file, over the latter [1], from which it is told: the
    tenth that a CAD model leaves out (cables, screws, grease) is usual."""
    least_errors_from_device: float = 3.0
    """The same difference over the standard deviation of the fitted inertia [1]."""

    # Calibration of foreign FMUs.
    least_size_of_difference_step_over_unit: float = 1e-3
    """Size of a parameter at 0 over the unit of its coordinate [1]: the difference quotient needs a step there, too."""
    difference_steps_over_size: tuple[float, ...] = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2)
    """Steps of a difference quotient over the size of a parameter [1]: at the narrowest the error of second order is
    1e-8 and that of a solver of 1e-8 is 1e-4, while a wide step averages the jumps of events."""
    largest_change_of_quotient: float = 0.5
    """Change of a difference quotient from one step to the next wider one, RMS over RMS [1], up to which they agree."""
    negligible_change_of_quotient: float = 1e-3
    """The same [1] below which a change is the solver's error."""
    points_of_search: int = 50
    """Number of points around a minimum of a cost with jumps [1], at each reach."""
    reaches_of_search_in_std: tuple[float, ...] = (2.0, 1.0, 0.5)
    """Standard deviations of these points over those of the parameters [1], one round each."""
    least_logarithmic_range: float = 10.0
    """Upper over lower bound [1] from which a positive parameter of a foreign FMU moves in its logarithm."""
    least_serial_duration_s: float = 20.0
    """Expected duration of the starts of a fit [s] from which processes share them: to start one takes seconds."""
    expected_iterations_of_start: int = 20
    """Expected number of simulations of all runs with differences in one start [1]."""


THRESHOLDS = Thresholds()
"""Thresholds that the code of `identification/` uses."""
