"""Maps and regions of residual energy: made-up residuals that live in one place only."""

from collections.abc import Callable

import numpy as np
import pytest

from haptid.discrepancy.detect.localise import AXES, describe_regions, excess, maps, regions
from haptid.measurement.values.run import Array, Run

SIGMA = 1e-3
Gap = Callable[[Run, Array], Array]


def runs_with(gap: Gap, duration: float = 20.0) -> tuple[list[Run], list[Array]]:
    """Two runs of a sine, noise and the ``gap`` of run and speed [σ]; the simulation is the sine."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, duration, 0.01)
    runs, simulated = [], []
    for k, omega in enumerate((1.0, 2.0)):
        y = 0.3 * np.sin(omega * t)
        run = Run(
            file=f"run{k}.csv.gz", free_joints=(2,), t=t, u=0.01 * np.cos(omega * t)[:, None], y=y[:, None],
            posture=np.zeros(6), noise=np.array([SIGMA]), resolution=np.zeros(1), use="fit",
        )  # fmt: skip
        left = gap(run, np.gradient(y, t)) + rng.standard_normal(t.size)
        runs.append(run.but(y=(y + SIGMA * left)[:, None]))
        simulated.append(y)
    return runs, simulated


GAPS: dict[str, tuple[Gap, tuple[float, float]]] = {
    "position_rad": (lambda run, _: 8.0 * (run.y[:, 0] > 0.26), (0.25, 0.3)),
    "velocity_rad_s": (lambda _, v: 8.0 * (v < -0.5), (-0.6, -0.5)),
    "torque_Nm": (lambda run, _: 8.0 * (np.abs(run.u[:, 0]) < 0.0015), (-0.0017, 0.0017)),
    "time_s": (lambda run, _: 8.0 * (run.t > 18.5), (18.3, 20.0)),
    "direction": (lambda _, v: 3.0 * (v < 0), (-1.0, -1.0)),
    "run": (lambda run, _: 3.0 * np.cos(50 * run.t) * (run.file == "run1.csv.gz"), (1.0, 1.0)),
}


@pytest.mark.parametrize("variable", GAPS)
def test_a_gap_that_lives_in_one_variable_is_found_there(variable: str):
    gap, (lower, upper) = GAPS[variable]
    first = regions(maps(*runs_with(gap)))[0]
    assert first.variable == variable
    assert lower - 0.02 * abs(lower) <= first.lower <= first.upper <= upper + 0.02 * abs(upper)
    assert first.share_of_gap > 0.5
    assert first.share_of_rows < 0.55


def test_a_gap_of_one_cycle_and_one_of_one_frequency():
    cycle = runs_with(lambda run, _: 4.0 * (run.t >= 2 * np.pi) * (run.t < 4 * np.pi) * (run.file == "run0.csv.gz"))
    found = {r.variable: r for r in regions(maps(*cycle))}
    assert (found["cycle"].lower, found["cycle"].upper) == (1.0, 1.0)
    assert "in cycle 2" in found["cycle"].sentence([False])
    hum = regions(maps(*runs_with(lambda run, _: np.cos(50 * run.t))))[-1]
    assert hum.variable == "frequency_rad_s"
    assert hum.lower < 50.0 < hum.upper
    assert hum.share_of_gap > 0.9


def test_every_map_holds_the_same_energy_and_the_same_rows():
    made = maps(*runs_with(lambda run, v: v + run.t / 10))
    assert [m.variable for m in made] == list(AXES)
    for m in made:
        assert m.excess.sum() == pytest.approx(excess(made), rel=1e-9)
        assert m.rows.sum() == pytest.approx(4000)


def test_noise_alone_is_level_over_frequency():
    spectrum = maps(*runs_with(lambda run, _: np.zeros(run.t.size), duration=200.0))[-1]
    level = spectrum.excess / spectrum.rows
    assert np.all(np.abs(level) < 5.0 / np.sqrt(spectrum.rows / 2))


def test_sentences_name_files_directions_and_units():
    run = describe_regions(regions(maps(*runs_with(GAPS["run"][0]))), [False])
    assert "in run1.csv.gz, in 50 % of the samples." in run[0]
    assert "rad/s, in" in run[-1]
    assert "of the spectrum." in run[-1]
    direction = regions(maps(*runs_with(GAPS["direction"][0])))[0]
    assert "where the position of joint 2 falls" in direction.sentence([False], " of joint 2")
    position = regions(maps(*runs_with(GAPS["position_rad"][0])))[0]
    assert position.sentence([True]).split(" m, in")[0].split()[-2] == "and"
