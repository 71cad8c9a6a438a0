"""Inference of one joint: simulator, runs and fit in, `Posterior` out.

1. Choose the solver's inner step and the noise model, and find the mode under it.
2. Sample the posterior by ensembles.
3. Diagnose the chains: summaries, log densities of cycles and runs, PSIS-LOO, number of modes.
4. Predict the fitted and the held-out runs, and propose the next run.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from haptid.identification.simulators.protocol import Simulator
from haptid.identification.workers.workers import Here, Workers
from haptid.measurement.values.run import Array, Run
from haptid.noise.hyper import noise_prior_width
from haptid.noise.noise_model import NoiseModel
from haptid.uq.density.density import Density
from haptid.uq.density.forward import EachForward, Forward, KernelForward
from haptid.uq.density.laplace import SHORT, THOROUGH, Laplace
from haptid.uq.density.likelihood import cycle_scores
from haptid.uq.density.solver_step import distinct_steps, longest_step
from haptid.uq.prediction.choice import Problem, Scored, best, compare, refine, unseen_terms
from haptid.uq.prediction.next_run import next_run
from haptid.uq.prediction.predict import predict
from haptid.uq.prediction.stored_choice import digest_of_choice, read_choice, write_choice
from haptid.uq.result.arviz_door import leave_one_out
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.summary import chains_of, summarise
from haptid.uq.sampling.budget import shorten, tell_shortened
from haptid.uq.sampling.modes import count_modes
from haptid.uq.sampling.sampling import Sample, SamplingOptions, sample
from haptid.uq.thresholds import THRESHOLDS

TellStage = Callable[[str, float | None, str], None]
"""Function that is told the name of a step, the share of it that is done (None where nobody knows it), and figures."""


def _tell_nobody(stage: str, share: float | None, figures: str) -> None:
    """Take how far an inference is, and do nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InferOptions:
    """Options of an inference.

    Parameters
    ----------
    sampling
        Options of the sampler.
    noise_given
        Whether the sensor's noise is stated by the campaign (else it was estimated, and its factor has a wide prior).
    model
        Noise model; chosen by the held-out runs where None.
    stored, predicted
        Draws per chain in the file, and draws behind a predictive band.
    sensitivity
        Whether mean and standard deviation are also computed with all priors half and twice as wide.
    short
        Whether the effort is bounded: short climbs choose the noise model, at one inner step, and chains whose steps
        simulate much have fewer of them, in fewer ensembles (`shorten`).
    """

    sampling: SamplingOptions = field(default_factory=SamplingOptions)
    noise_given: bool = True
    model: NoiseModel | None = None
    stored: int = 500
    predicted: int = 1000
    sensitivity: bool = False
    short: bool = False


QUICK = SamplingOptions(chunk=40, burn=60, pilot=0, longest=120)
"""Options of a short sampling, without a trial of moves."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Chosen:
    """Noise models with their scores, the chosen one, and the problem with the simulator that scored them."""

    problem: Problem
    scored: tuple[Scored, ...]
    one: Scored


def _choose(
    problem: Problem, theta: Array, options: InferOptions, tell: Callable[[str], None], white: Laplace | None = None
) -> _Chosen:
    if options.model is None:
        scored = compare(problem, theta, white=white, seed=options.sampling.seed, tell=tell)
    else:
        scored = (Scored(model=options.model, mode=problem.mode(options.model, theta), score=0.0),)
    return _Chosen(problem=problem, scored=scored, one=best(scored))


def _with_kernel(problem: Problem, share: float, step: float | None) -> Problem:
    """Return a problem that the compiled kernel simulates with an inner step [s]; ``problem`` itself where None."""
    if step is None:
        return problem
    forward = KernelForward(
        equations=problem.simulator.equations, step=step,
        correction=share * THRESHOLDS.inner_step_of_correction_s,
    )  # fmt: skip
    return replace(problem, simulator=forward.simulator(), forward=forward)


def _with_longest_step(
    problem: Problem, theta: Array, options: InferOptions, share: float, tell: Callable[[str], None]
) -> _Chosen:
    """Choose the noise model with the compiled kernel and the longest inner step that suffices under that model.

    The search begins at the step that suffices under white noise: one mode a step, where a choice takes one per model.
    A short inference chooses at that step alone, and shortens the step under the chosen model.
    """
    with_step = partial(_with_kernel, problem, share)
    every = distinct_steps([share * step for step in THRESHOLDS.inner_steps_s], (*problem.fitted, *problem.unseen))
    white, first = longest_step(lambda step: with_step(step).mode(NoiseModel(), theta), lambda mode: mode, every)
    coarse: list[_Chosen] = []

    def choose(step: float) -> _Chosen:
        if coarse and options.short:
            tell(f"{coarse[0].one.model.id}, inner step {1e3 * step:g} ms")
            finer = with_step(step)
            return replace(coarse[0], problem=finer, one=refine(finer, coarse[0].one))
        known = white if step == first else None
        coarse.append(
            _choose(
                with_step(step), theta, options, lambda figures: tell(f"{figures}, inner step {1e3 * step:g} ms"), known
            )
        )
        return coarse[-1]

    steps = [step for step in every if step <= first]
    return longest_step(choose, lambda made: made.one.mode, steps)[0]


def infer(  # noqa: PLR0913 # what a posterior is made of and where its chains are kept
    simulator: Simulator,
    runs: Sequence[Run],
    theta: Array,
    options: InferOptions,
    *,
    joint: int,
    workers: Workers | None = None,
    folder: Path | None = None,
    tell: TellStage = _tell_nobody,
    forward: Forward | None = None,
    share_of_steps: float = 1.0,
) -> Posterior:
    """Infer the posterior of a joint's parameters and of its noise model.

    Parameters
    ----------
    simulator
        Simulator with sensitivities; its equations are those of the posterior.
    runs
        All runs of the joint; those with use ``fit`` are fitted, those with use ``validate`` choose the noise model.
    theta
        Fitted parameters, the start of the climb to the mode, shape (n_p,).
    options
        Options of the inference.
    joint
        Number of the joint.
    workers
        Processes of the sampler; this process where None.
    folder
        Folder in which the choice of the noise model and chains are kept, so that a killed command can continue.
    tell
        Told the name of the step, the share of it that is done, None where nobody knows it, and figures.
    forward
        Simulation of many parameter sets by the same equations as ``simulator``, which the sampler runs; the compiled
        kernel with the longest inner step that suffices where None.
    share_of_steps
        Share of the usual inner steps [1] that the kernel tries, where the fit needed a finer one.

    Returns
    -------
    Posterior
        Chains under the chosen noise model, summaries of the parameters, log densities by cycle and run, and the
        predictive bands of all runs.

    Raises
    ------
    NumericalError
        Where the posterior has no finite density at the fit, or hardly any near it.
    """
    begun = time.perf_counter()
    tell("noise model", None, "")

    def tell_candidate(figures: str) -> None:
        # How many inner steps will be tried nobody knows, so that no share is told.
        tell("noise model", None, figures)

    problem = Problem(
        simulator=simulator,
        forward=forward or EachForward(simulator=simulator),
        fitted=tuple(run for run in runs if run.use == "fit"),
        unseen=tuple(run for run in runs if run.use == "validate"),
        noise_width=noise_prior_width(stated=options.noise_given),
        climb=SHORT if options.short else THOROUGH,
    )

    def choose() -> _Chosen:
        if forward:
            return _choose(problem, theta, options, tell_candidate)
        return _with_longest_step(problem, theta, options, share_of_steps, tell_candidate)

    digest = digest_of_choice(problem, theta, (options.sampling.seed, options.model, share_of_steps))
    chosen = _kept_or(choose, folder, digest, partial(_with_kernel, problem, share_of_steps))
    simulator, mode, seed = chosen.problem.simulator, chosen.one.mode, options.sampling.seed
    cost = sum(mode.density.forward.inner_steps(terms.run) for terms in mode.density.terms)
    sampling = shorten(options.sampling, cost, mode.eta.size) if options.short else options.sampling
    tell("sampling", 0.0, "")
    drawn = sample(mode, sampling, workers=workers or Here(), folder=folder, tell=partial(tell, "sampling"))
    tell("diagnostics", 0.0, "")
    rng = np.random.default_rng([seed, 11])
    density = mode.density
    chains = chains_of(drawn)
    most = THRESHOLDS.stored_draws_of_short_chains // len(chains) if options.short else options.stored
    draws = _thin(chains, min(options.stored, most))
    cycles, per_run = _log_densities(density, draws)
    few = _thin(draws.reshape(1, -1, draws.shape[-1]), options.predicted)[0]  # of all chains together
    every = (*density.terms, *unseen_terms(mode, simulator, chosen.problem.unseen))
    covariance = np.cov(drawn.flat().T).reshape(drawn.chain.shape[-1], -1)
    return Posterior(
        joint=joint,
        candidates=chosen.scored,
        chosen=chosen.one,
        mode=mode,
        sample=drawn,
        parameters=summarise(density.coordinates, drawn, rng),
        draws=draws,
        cycle_log_density=cycles,
        run_log_density=per_run,
        loo=leave_one_out(cycles),
        bands=tuple(predict(density, terms, few, rng) for terms in every),
        modes=count_modes(drawn.chain),
        next_run=next_run(mode, simulator, covariance),
        sensitivity=_sensitivity(chosen.problem, chosen.one, drawn) if options.sensitivity else {},
        wall_s=time.perf_counter() - begun,
        shortened=tell_shortened(options.sampling, sampling, cost),
    )


def _kept_or(
    choose: Callable[[], _Chosen], folder: Path | None, digest: str, with_kernel: Callable[[float | None], Problem]
) -> _Chosen:
    """Read the noise model that a killed command had chosen from the same inputs, or choose and keep it."""
    if folder is None:
        return choose()
    kept = read_choice(folder, digest, with_kernel)
    if kept is not None:
        problem, scored, one = kept
        return _Chosen(problem=problem, scored=scored, one=one)
    chosen = choose()
    write_choice(folder, digest, chosen.problem, chosen.scored, chosen.one)
    return chosen


def _thin(chains: Array, count: int) -> Array:
    """Return evenly spaced draws of every chain (n_chains, n_draws, n), at most ``count``."""
    total = chains.shape[1]
    picked = np.unique(np.linspace(0, total - 1, min(count, total)).astype(int))
    return np.asarray(chains[:, picked])


def _log_densities(density: Density, draws: Array) -> tuple[Array, Array]:
    """Return log densities by cycle (n_chains, n_draws, n_cycles) and by run (n_chains, n_draws, n_runs)."""
    chains, count, n = draws.shape
    flat = draws.reshape(-1, n)
    cycles, runs = [], []
    for block in np.array_split(flat, max(len(flat) // 64, 1)):  # blocks bound the memory of the simulated positions
        thetas, hyper = density.coordinates.thetas(block), density.hyper(block)
        simulated = [density.simulate(block, terms) for terms in density.terms]
        runs.append(density.log_likelihoods(block, simulated))
        scores = [
            cycle_scores(terms, density.model, density.equations, thetas, hyper, y)
            for terms, y in zip(density.terms, simulated, strict=True)
        ]
        cycles.append(np.concatenate(scores, axis=1))
    return np.concatenate(cycles).reshape(chains, count, -1), np.concatenate(runs).reshape(chains, count, -1)


def _sensitivity(problem: Problem, chosen: Scored, drawn: Sample) -> dict[str, dict[str, tuple[float, float]]]:
    """Return mean and standard deviation of every coordinate's value with all priors half, once and twice as wide.

    Importance weights w ∝ p_widened(η)/p(η) of at most about 8000 draws of the chains: the likelihood cancels, so that
    no simulation is needed.
    """
    flat = drawn.flat()[:: max(drawn.flat().shape[0] // 4000, 1)]
    coordinates = chosen.mode.density.coordinates
    values = coordinates.values(flat)
    base = coordinates.log_prior(flat)
    table: dict[str, dict[str, tuple[float, float]]] = {}
    for label, factor in (("half", 0.5), ("stated", 1.0), ("double", 2.0)):
        moved = replace(coordinates, widen=problem.widen * factor).log_prior(flat) - base
        weight = np.exp(moved - moved.max())
        weight /= weight.sum()
        mean = weight @ values
        std = np.sqrt(weight @ (values - mean) ** 2)
        table[label] = {name: (float(m), float(s)) for name, m, s in zip(coordinates.names, mean, std, strict=True)}
    return table
