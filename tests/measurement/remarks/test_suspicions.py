"""Slips of units, signs and columns are remarked with the remedy; what is right is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptid.measurement.checks.summary import summarise, tell_table
from haptid.measurement.format.embedded import FOLDERS, embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.remarks.between_runs import find_misnamed, twins
from haptid.measurement.remarks.limits import Limits
from haptid.measurement.remarks.suspicions import suspicions
from haptid.measurement.signals.noise import contrasts, with_noise
from haptid.measurement.tables.misnamed import advice
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run
from haptid.support.tables import Table
from tests.real_data import DATA

WORDS = (
    "degrees?",
    "counts?",
    "milliseconds?",
    "sign wrong",
    "clipped",
    "command limited",
    "is stated",
    "same rows",
    "swapped?",
    "never changes",
    "cell cut",
    "other runs",
    "wraps by",
    "rows are missing",
    "do not show the noise",
)


def a_run(t: Array, u: Array, y: Array, *, noise: float = np.nan, file: str = "a.csv", use: str = "fit") -> Run:
    return Run(
        file=file,
        free_joints=(0,),
        t=t,
        start_time=0.0,
        u=u[:, None],
        y=y[:, None],
        v=None,
        prismatic=(False,),
        extra={},
        posture=np.zeros(0),
        noise=np.array([noise]),
        resolution=np.array([np.nan]),
        use=use,
        hold="zero",
        reason="",
        notes=(),
    )


def moved(*, damping: float = 0.02, seed: int = 0) -> tuple[Array, Array, Array]:
    """A spring, a damper and a mass under a cosine torque, in the steady state, read with noise of 1e-4 rad."""
    t = np.arange(0.0, 10.0, 1e-3)
    omega, gain = 3.0, 1.0 / complex(0.05 - 0.01 * 3.0**2, damping * 3.0)
    y = np.real(0.01 * gain * np.exp(1j * omega * t)) + 1e-4 * np.random.default_rng(seed).standard_normal(t.size)
    return t, 0.01 * np.cos(omega * t), y


def remarks_on(run: Run) -> str:
    full = with_noise(run.but(noise=np.array([np.nan])))
    return "; ".join(suspicions(run, full, 0))


def test_what_is_right_is_not_remarked():
    t, u, y = moved()
    assert not remarks_on(a_run(t, u, y, noise=1e-4))


@pytest.mark.parametrize("seed", range(5))
def test_little_friction_is_no_wrong_sign(seed: int):
    t, u, y = moved(damping=1e-5, seed=seed)
    assert not remarks_on(a_run(t, u, y))


@pytest.mark.parametrize(
    ("run", "word"),
    [
        (lambda t, u, y: a_run(t, u, 180 * y), "degrees?"),
        (lambda t, u, y: a_run(t, u, np.round(4096 * y)), "counts? then multiply the position by the angle of one"),
        (lambda t, u, y: a_run(t, u, np.mod(20 * y, 2 * np.pi)), "the position wraps by 6.283 rad"),
        (lambda t, u, y: a_run(1000 * t, u, y), "milliseconds?"),
        (lambda t, u, y: a_run(t, -u, y), "sign wrong"),
        (lambda t, u, y: a_run(t, y, u + 1e-6 * np.random.default_rng(1).standard_normal(t.size)), "columns swapped"),
        (lambda t, u, y: a_run(t, u, np.clip(y, -0.05, 0.05)), "clipped"),
        (lambda t, u, y: a_run(t, u, y, noise=1e-12), "is stated"),
        (lambda t, u, y: a_run(t, u, y, noise=1.0), "is stated"),
    ],
)
def test_slips_are_remarked(run, word: str):
    t, u, y = moved()
    assert word in remarks_on(run(t, u, y))


@pytest.mark.parametrize("signal", ["position", "torque"])
def test_a_number_far_from_all_others_marks_missing_readings(signal: str):
    """-9999 among degrees, already converted, was taken for a travel in degrees."""
    t, u, y = moved()
    (y if signal == "position" else u)[[120, 121, 4000]] = -9999 * 0.0174533
    said = remarks_on(a_run(t, u, y))
    unit = "rad" if signal == "position" else "N m"
    assert said.startswith(f"the {signal} is -174.516 {unit} in 3 rows, first at 0.12 s, far from all others")
    assert "degrees?" not in said


def test_a_step_to_the_end_of_travel_marks_nothing():
    t, u, y = moved()
    y[-200:] = y.max() + 0.1
    assert "far from all others" not in remarks_on(a_run(t, u, y))


def test_few_rows_tell_no_noise():
    t, u, y = (column[::500] for column in moved())
    assert "is stated" not in remarks_on(a_run(t, u, y, noise=1e-4))


def test_rows_at_20_hz_are_no_milliseconds():
    t, u, y = (column[::50] for column in moved())
    assert not remarks_on(a_run(t, u, y))


def test_a_run_to_validate_with_the_rows_of_a_run_to_fit():
    t, u, y = moved()
    runs = [a_run(t, u, y), a_run(t, u, y, file="b.csv", use="validate"), a_run(t, u, y, file="c.csv")]
    found = twins(runs)
    assert found.keys() == {"b.csv", "c.csv"}
    assert "same rows as a.csv, which is used otherwise" in found["b.csv"]
    assert "same rows as a.csv: they count twice" in found["c.csv"]


@pytest.mark.parametrize("name", FOLDERS)
def test_nothing_is_suspected_of_the_embedded_campaigns(name: str):
    rows = summarise(read_campaign(embedded_campaign(name)))
    assert not [remark for row in rows for remark in row.remarks if any(word in remark for word in WORDS)]


@pytest.mark.real("dvrk_mtm_joint4", "dfki_double_pendulum_a0")
@pytest.mark.filterwarnings("ignore::haptid.measurement.values.warning.CampaignWarning")
@pytest.mark.parametrize("name", ["dvrk_mtm_joint4", "dfki_double_pendulum_a0"])
def test_nothing_is_suspected_of_real_machines(name: str):
    rows = summarise(read_campaign(DATA / name))
    found = [remark for row in rows for remark in row.remarks]
    assert not [remark for remark in found if any(word in remark for word in WORDS if word != "is stated")]


def test_contrasts_do_not_depend_on_the_block(monkeypatch: pytest.MonkeyPatch):
    t, _, y = moved()
    whole = contrasts(t, y, 5)
    monkeypatch.setattr("haptid.measurement.signals.noise.ROWS_PER_BLOCK", 777)
    assert np.array_equal(contrasts(t, y, 5), whole)


def test_torque_far_above_the_devices_limit_is_remarked():
    t, u, y = moved()
    run = a_run(t, 1000 * u, y)
    limits = Limits(torque=0.1)
    assert "in mN m? then multiply by 0.001" in "; ".join(suspicions(run, with_noise(run), 0, limits=limits))
    assert not suspicions(a_run(t, u, y), with_noise(run), 0, limits=limits)


@pytest.mark.parametrize(
    ("column", "there", "says"),
    [
        ("time_s", "time_ms", "did you mean 'time_ms' there? multiply it by 0.001 and name it time_s"),
        ("time_s", "t", "did you mean 't' there? if it holds seconds, keep the numbers and name it time_s"),
        (
            "position_3_rad",
            "position_3_deg",
            "did you mean 'position_3_deg' there? multiply it by 0.0174533 and name it position_3_rad",
        ),
        (
            "position_3_rad",
            "q3",
            "did you mean 'q3' there? if it holds radians, keep the numbers and name it position_3_rad",
        ),
        (
            "torque_0_Nm",
            "torque_0_mNm",
            "did you mean 'torque_0_mNm' there? multiply it by 0.001 and name it torque_0_Nm",
        ),
        (
            "torque_0_Nm",
            "tau_0",
            "did you mean 'tau_0' there? if it holds N m, keep the numbers and name it torque_0_Nm",
        ),
        ("torque_0_Nm", "torqe_0_Nm", "did you mean 'torqe_0_Nm' there?"),
        ("torque_0_Nm", "weather", ""),
    ],
)
def test_columns_in_other_units_and_names_are_advised(column: str, there: str, says: str):
    assert advice(column, ("other", there)) == says


STEP = 1.5e-4


def in_steps(y: Array, step: float = STEP) -> Array:
    return np.round(y / step) * step


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda y: np.clip(in_steps(y), -0.05, 0.05), True),
        (lambda y: np.clip(in_steps(y), -300 * STEP, 300 * STEP), True),
        (lambda y: in_steps(np.clip(y, -0.05, 0.05)), True),
        (in_steps, False),
        (lambda y: in_steps(y, 5e-3), False),
    ],
)
def test_clipped_positions_of_an_encoder_are_remarked(change, told: bool):
    t, u, y = moved()
    assert ("clipped" in remarks_on(a_run(t, u, change(y)))) is told


def test_degrees_of_a_small_travel_are_told_by_the_device_or_the_encoder():
    t, u, y = moved()
    degrees = np.degrees(y)
    run = a_run(t, u, degrees)
    assert "the device's joint has 1" in "; ".join(suspicions(run, with_noise(run), 0, limits=Limits(travel=1.0)))
    assert "the position's step is 360/16384: degrees?" in remarks_on(a_run(t, u, in_steps(degrees, 360 / 2**14)))
    assert not remarks_on(a_run(t, u, in_steps(y, 2 * np.pi / 2**14)))
    # Many turns of a motor whose encoder has 4096 counts of 2π/4096.
    assert "degrees?" not in remarks_on(a_run(t, u, in_steps(200 * y, 2 * np.pi / 2**12)))


def test_rows_that_are_the_same_to_the_last_digits_are_remarked():
    t, u, y = moved()
    runs = [a_run(t, u, y), a_run(t, u, y * (1 + 1e-15), file="b.csv", use="validate"), a_run(t, u, 1.01 * y, file="c")]
    assert twins(runs).keys() == {"b.csv"}


def cosine(omega: float, file: str) -> Run:
    t = np.arange(0.0, 10.0, 0.01)
    return a_run(t, np.cos(omega * t), np.sin(omega * t), file=file)


@pytest.mark.parametrize(
    ("named", "remarked"),
    [
        ({"joint4_w6.28.csv": 10.68, "joint4_w10.68.csv": 6.283}, {"joint4_w6.28.csv", "joint4_w10.68.csv"}),
        ({"joint4_w6.28.csv": 6.283, "joint4_w10.68.csv": 10.68}, set()),
        ({"f1Hz.csv": 10.68, "f1.7Hz.csv": 6.283}, {"f1Hz.csv", "f1.7Hz.csv"}),
        ({"w2.csv": 2.0, "w3.csv": 3.0, "w4.csv": 4.0, "w5.csv": 7.0}, {"w5.csv"}),
        ({"run1.csv": 2.0, "run2.csv": 3.0, "run3.csv": 4.5}, set()),
        ({"trial_12.csv": 2.0}, set()),
        # Numbers of runs, two of which happen to be their frequencies.
        ({"essai1.csv": 6.283, "essai2.csv": 12.566, "essai3.csv": 3.1416}, set()),
    ],
)
def test_tables_under_each_others_names(named: dict[str, float], remarked: set[str]):
    assert find_misnamed([cosine(omega, file) for file, omega in named.items()]).keys() == remarked


@pytest.mark.parametrize(
    ("slides", "heading"),
    [((False, False), "torque ± N m"), ((True, True), "force ± N"), ((False, True), "torque ± N m, N")],
)
def test_the_table_has_the_unit_of_the_torque(slides: tuple[bool, ...], heading: str):
    t = np.arange(0.0, 4.0, 0.01)
    runs = [
        a_run(t, np.cos(3 * t), 0.3 * np.sin(3 * t), file=f"{k}.csv").but(prismatic=(one,), free_joints=(k,))
        for k, one in enumerate(slides)
    ]
    read = Campaign(folder=Path(), title="t", device="single_joint", measured=False, runs=tuple(runs))
    table = tell_table(summarise(read))[0]
    assert isinstance(table, Table)
    assert heading in table.header
