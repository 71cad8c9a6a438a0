"""p over the whole catalogue: by the noise model, and by random signs of stretches."""

import numpy as np
import pytest

from haptid.discrepancy.detect.chi_squared import log_tails
from haptid.discrepancy.detect.familywise import by_sign_flips, independent_tests
from haptid.discrepancy.detect.signatures import Point
from haptid.measurement.values.run import Array, Run
from tests.discrepancy.finding.test_finding import EFFECTS, study_with

POINTS = [Point(key=f"{k}", values=({},), columns=slice(k, k + 1)) for k in range(8)]
POINTS += [Point(key="pair", values=({}, {}), columns=slice(8, 10))]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, ...]:
    return study_with(tmp_path_factory.mktemp("family") / "c", {}, EFFECTS).fitted


def signatures(runs: tuple[Run, ...]) -> Array:
    """Slow waves over all rows, as signatures are: neighbouring rows are alike."""
    rows = sum(run.y.size for run in runs)
    rng = np.random.default_rng(4)
    phase = np.linspace(0, 2 * np.pi, rows)[:, None] * rng.uniform(3, 40, 10) + rng.uniform(0, 6, 10)
    return np.asarray(np.sin(phase))


def smallest(runs: tuple[Run, ...], residuals: list[Array]) -> Array:
    D = signatures(runs)
    G = D.T @ D
    return np.array([min(by_sign_flips(r, D, G, POINTS, runs, seed=k).values()) for k, r in enumerate(residuals)])


def test_noise_of_heavy_tails_gives_p_at_its_rate(runs: tuple[Run, ...]):
    rng = np.random.default_rng(1)
    size = rng.uniform(0.2, 4.0, 150)  # noise other than stated: no model of it is needed
    rows = sum(run.y.size for run in runs)
    p = smallest(runs, [s * rng.standard_t(3, rows) for s in size])
    assert 0.05 * 150 - 3 * np.sqrt(150 * 0.05) < (p < 0.05).sum() < 0.05 * 150 + 3 * np.sqrt(150 * 0.05)
    assert abs(np.mean(p) - 0.5) < 3 / np.sqrt(12 * 150)


def test_what_is_there_stands_out_and_other_entries_do_not(runs: tuple[Run, ...]):
    D = signatures(runs)
    r = 0.3 * D[:, 3] + np.random.default_rng(2).standard_normal(D.shape[0])
    D = np.linalg.qr(D)[0]
    p = by_sign_flips(r, D, D.T @ D, POINTS, runs)
    assert min(p, key=lambda key: p[key]) == "3"
    assert p["3"] == 1 / 2001


def test_both_ways_agree_on_white_noise(runs: tuple[Run, ...]):
    D = signatures(runs)
    G = D.T @ D
    tests = independent_tests(G, POINTS)
    rng = np.random.default_rng(3)
    for _ in range(5):
        r = rng.standard_normal(D.shape[0])
        one = []
        for point in POINTS:
            c, block = D[:, point.columns].T @ r, G[point.columns, point.columns]
            one.append(np.exp(log_tails(c @ np.linalg.solve(block, c), len(point.values))))
        flipped = min(by_sign_flips(r, D, G, POINTS, runs).values())
        assert abs(flipped + np.expm1(tests * np.log1p(-min(one)))) < 0.1
