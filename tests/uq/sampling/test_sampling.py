"""Ensembles on a density whose answer is known, and chains that go on after any interruption."""

import multiprocessing
import time

import numpy as np
import pytest

from haptid.identification.workers.workers import Here
from haptid.uq.sampling import chunk
from haptid.uq.sampling.autocorrelation import autocorrelation_time
from haptid.uq.sampling.chunk import Chunk
from haptid.uq.sampling.modes import count_modes
from haptid.uq.sampling.moves import MOVES
from haptid.uq.sampling.sampling import SamplingOptions, fit_proposal, sample
from tests.uq.toys import COVARIANCE, MEAN, start, start_in_corner

SHORT = SamplingOptions(chunk=40, burn=40, pilot=40, longest=400, seed=3)


@pytest.mark.parametrize("move", MOVES)
def test_every_move_samples_the_normal_distribution(move):
    options = SamplingOptions(chunk=200, burn=200, pilot=0, longest=1200, move=move, seed=1)
    found = sample(start(), options)
    draws, errors = found.flat(), np.sqrt(np.diag(COVARIANCE) / found.effective)
    assert np.all(np.abs(draws.mean(axis=0) - MEAN) < 5 * errors)
    scale = np.sqrt(np.outer(np.diag(COVARIANCE), np.diag(COVARIANCE)))
    np.testing.assert_allclose(np.cov(draws.T) / scale, COVARIANCE / scale, atol=0.12)


def test_independent_proposals_are_the_fastest_on_a_normal_density():
    found = sample(start(), SHORT)
    assert found.move == "independent"
    assert set(found.trials) == set(MOVES)


def test_a_mode_on_the_ends_of_many_ranges_is_left():
    """One of 4096 directions leads inside, so that no walker drawn around it had a finite density."""
    found = sample(start_in_corner(), SamplingOptions(chunk=200, burn=200, pilot=0, longest=1200, seed=1))
    draws, errors = found.flat(), 1 / np.sqrt(found.effective)  # mean and scatter of each are 1
    assert np.all(np.abs(draws.mean(axis=0) - 1) < 5 * errors)
    assert np.all(draws >= 0)


def test_stops_when_the_autocorrelation_time_is_known_and_says_so_when_not():
    known = sample(start(), SamplingOptions(chunk=100, burn=50, pilot=0, longest=3000, seed=2))
    assert known.reached
    assert known.chain.shape[1] >= 50 * known.tau.max()
    assert known.chain.shape[1] < 3000
    assert not sample(start(), SamplingOptions(chunk=20, burn=20, pilot=0, longest=40)).reached


def test_nothing_is_printed_at_ctrl_c(capsys, monkeypatch):
    """The sampler's library printed its walkers and a traceback on the stdout that holds JSON."""
    begun = start()

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(chunk, "moves", lambda *_: monkeypatch.setattr(type(begun.density), "__call__", interrupted))
    with pytest.raises(KeyboardInterrupt):
        sample(begun, SHORT)
    assert capsys.readouterr() == ("", "")


def test_same_seed_same_bits_other_seed_other_chain():
    first, second = sample(start(), SHORT), sample(start(), SHORT)
    np.testing.assert_array_equal(first.chain, second.chain)
    other = sample(start(), SamplingOptions(chunk=40, burn=40, pilot=40, longest=400, seed=4))
    assert not np.array_equal(first.chain[:, :40], other.chain[:, :40])


def test_a_folder_of_chunks_is_taken_up_and_one_of_another_problem_is_not(tmp_path):
    whole = sample(start(), SHORT)
    assert np.array_equal(sample(start(), SHORT, folder=tmp_path).chain, whole.chain)
    for path in sorted(tmp_path.glob("main_*"))[5:]:
        path.unlink()
    np.testing.assert_array_equal(sample(start(), SHORT, folder=tmp_path).chain, whole.chain)
    moved = sample(start(scale=1.1), SHORT, folder=tmp_path)
    assert not np.array_equal(moved.chain[:, :40], whole.chain[:, :40])


LONG = SamplingOptions(chunk=40, burn=40, pilot=40, longest=400, lengths=1e9, seed=3)


def _sample_slowly(folder):
    sample(start(), LONG, folder=folder, tell=lambda *_: time.sleep(0.0001))


def test_killed_at_random_moments_the_chain_ends_the_same(tmp_path):
    """Up to ten kills by SIGKILL, each at a random moment after another file was written; then one run to the end."""
    rng = np.random.default_rng(0)
    fork = multiprocessing.get_context("fork")
    for _ in range(10):
        process = fork.Process(target=_sample_slowly, args=(tmp_path,))
        before = len(list(tmp_path.glob("*.h5")))
        process.start()
        while process.is_alive() and len(list(tmp_path.glob("*.h5"))) == before:
            time.sleep(0.005)
        time.sleep(rng.uniform(0.0, 0.1))
        process.kill()
        process.join()
    assert list(tmp_path.glob("*.h5"))
    np.testing.assert_array_equal(sample(start(), LONG, folder=tmp_path).chain, sample(start(), LONG).chain)


def test_autocorrelation_time_of_an_ar1_process():
    rng, phi = np.random.default_rng(0), 0.8
    shocks = rng.standard_normal((2, 3000, 16, 1))
    chain = np.zeros_like(shocks)
    for k in range(1, 3000):
        chain[:, k] = phi * chain[:, k - 1] + shocks[:, k]
    assert autocorrelation_time(chain)[0] == pytest.approx((1 + phi) / (1 - phi), rel=0.08)


def test_separate_modes_are_counted():
    rng = np.random.default_rng(0)
    chain = rng.standard_normal((4, 50, 8, 3))
    assert count_modes(chain) == 1
    chain[2] += 30.0
    assert count_modes(chain) == 2


class _StoppedAt(Here):
    """Workers that Ctrl-C stops before a task of some call."""

    def __init__(self, calls: int, task: int) -> None:
        self.calls, self.task = calls, task

    def until(self, function, tasks, more, **told):
        self.calls -= 1

        def stop(done):
            needed = more(done)
            if self.calls < 0 and len(done) == self.task:
                raise KeyboardInterrupt
            return needed

        return super().until(function, tasks, stop, **told)


def test_ctrl_c_keeps_the_chunks_of_the_ensembles_that_are_through(tmp_path):
    whole = sample(start(), SHORT)
    with pytest.raises(KeyboardInterrupt):
        sample(start(), SHORT, folder=tmp_path, workers=_StoppedAt(calls=5, task=3))
    assert [path.name for path in sorted(tmp_path.glob("main_*_00001.h5"))] == [f"main_{e}_00001.h5" for e in range(3)]
    np.testing.assert_array_equal(sample(start(), SHORT, folder=tmp_path).chain, whole.chain)


def test_a_lone_walker_at_the_mode_makes_no_proposal_of_one_point():
    """All walkers took the same independent draw then, and a step along their difference had no direction."""
    rng = np.random.default_rng(0)
    chain, log_prob = rng.standard_normal((40, 8, 3)), np.full((40, 8), -1e4)
    chain[:, 2], log_prob[:, 2] = 0.5, 0.0
    proposal = fit_proposal([Chunk(chain=chain, log_prob=log_prob, accepted=np.zeros(8))])
    drawn = proposal.draw(np.random.RandomState(0), 50)
    assert np.ptp(drawn, axis=0).min() > 0.5
    log_prob[:, :6] = 0.0
    reached = fit_proposal([Chunk(chain=chain, log_prob=log_prob, accepted=np.zeros(8))])
    assert reached.mean == pytest.approx(chain[20:, :6].reshape(-1, 3).mean(axis=0))
