"""Thresholds of `discrepancy/study/`: bounds of parameters, inner steps, the budget."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyThresholds:
    """Bounds of parameters, inner steps and the budget of a study."""

    # Step 1: how far parameters may lie from their first guess.
    largest_bound_over_first_guess: float = 100.0
    """Largest ratio of a bound to the first guess, for parameters of logarithmic scale [1]."""
    largest_stiffness_in_torque_per_travel: float = 40.0
    """Largest stiffness, as a multiple of the largest torque over the travel [1]."""

    # Step 3: inner steps from which refinement begins.
    coarse_step_s: float = 2.5e-3
    """Inner step of sensitivities and of first tries [s]."""
    longest_coarse_step_over_needed: float = 8.0
    """Longest step of sensitivities over the one that the readings need [1]; joints that need 0.3 ms and more keep
    `coarse_step_s`."""
    signature_step_s: float = 5e-3
    """Inner step of signatures and of the first sieve [s].

    Signatures are differences of simulations at the same step. The sieve at 5 ms in the place of 2.5 ms took an
    unlisted case from 116 s to 86 s.
    """

    most_states_of_sketch_with_sensitivities: int = 4
    """Number of states of the nominal model [1] up to which the kernels of signatures have sensitivities too.

    With one state a friction law, they take 0.2 s an effect, less than to compile the kernels of those effects anew
    that are fitted. With the twelve of the generalised Maxwell-slip law they take 2 s.
    """

    # Step 10: the budget.
    most_simulated_runs: int = 30_000
    """Simulated runs after which no further combinations of effects are tried (``--effort``).

    145 of 146 names came sooner. What no effect of the catalogue explains took up to 65,000 runs without the limit.
    """

    # Long recordings.
    most_rows_searched: int = 25_000
    """Number of fitted rows [1] up to which a search takes each of them: of more, several are merged into one.

    Five runs of 20 s at 2 kHz took 4.6 GB and were not done after 266 s."""
    largest_torque_change_within_merged_rows: float = 0.1
    """Largest RMS difference between the torque and the linear course in its place, over that of the torque [1]: a dead
    band or a saturation acts on the torque itself."""

    # Held-out runs.
    least_held_out_runs_to_seal: int = 3
    """Number of held-out runs [1] from which some are sealed: two are left that choose."""
    sealed_share_of_held_out: float = 1.0 / 3.0
    """Share of the held-out runs that are sealed [1]."""

    # Several joints at once.
    most_joints: int = 3
    """Largest number of joints that a search takes on: the equations are solved for the accelerations symbolically."""
    most_coupled_effects_begun: int = 16
    """Number of catalogue effects with the best scores that are begun: a kernel with sensitivities compiles for
    seconds."""
