"""Verdict on a joint whose torque is scored, from what its names, the best black box and repetition leave."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.finding.soundness import Soundness
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.job.summary import tell_finding
from haptid.discrepancy.torque.study import RunFriction
from haptid.support.tables import Table

BEFORE = 50e-3


def finding_that_leaves(
    after: float, *, floor: float | None, black_box: float | None, fitted: float = 0.0, names: int = 1
) -> TorqueFinding:
    """Return a finding that leaves ``after`` of 50 mN m on held-out rows, and ``fitted`` of the fitted ones."""
    study = SimpleNamespace(unseen_rows=(), fitted_rows=(), names=lambda _: np.ones(4, dtype=bool))
    final = SimpleNamespace(effects=("one",) * names, unseen=np.full(4, after), left=max(fitted, after), study=study)
    return TorqueFinding(
        search=SimpleNamespace(final=final, rivals=()),
        gaps={"validate": Gap(before=BEFORE, after=after, noise=1e-4)},
        regions=(), maps=(), remaining=None, floor=floor, black_box=black_box, nominal_loop=None, final_loop=None,
        fmu=None, considered=1, wall_s=0.0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("after", "floor", "black_box", "verdict"),
    [
        # What is left repeats no better than the floor.
        (20e-3, 19e-3, 10e-3, "named"),
        # As much closed as the black box closes, and most of what repeats.
        (25e-3, 19e-3, 30e-3, "named"),
        # As much as the black box, but two thirds of what repeats.
        (33e-3, 19e-3, 33e-3, "partly_named"),
        # Most of what repeats, but the black box closes far more.
        (30e-3, 19e-3, 20e-3, "partly_named"),
        # More than the black box, which hardly closes anything, and little of what repeats.
        (45e-3, 19e-3, 49e-3, "partly_named"),
        # Without a second pass all that is left may repeat.
        (45e-3, None, 49e-3, "partly_named"),
        (24e-3, None, 30e-3, "named"),
        (30e-3, None, 30e-3, "partly_named"),
        (45e-3, None, None, "partly_named"),
    ],
)
def test_names_stand_alone_where_little_that_repeats_is_left(
    after: float, floor: float | None, black_box: float | None, verdict: str
):
    assert finding_that_leaves(after, floor=floor, black_box=black_box).verdict == verdict


@pytest.mark.parametrize(("fitted", "verdict"), [(19e-3, "nothing_missing"), (30e-3, "unlisted")])
def test_nothing_is_missing_only_where_fitted_runs_leave_the_floor_as_well(fitted: float, verdict: str):
    finding = finding_that_leaves(5e-3, floor=19e-3, black_box=6e-3, fitted=fitted, names=0)
    assert finding.verdict == verdict


@pytest.mark.parametrize(
    ("fitted", "unseen", "verdict"),
    [(50e-3, 166e-3, "named"), (117e-3, 166e-3, "unlisted"), (50e-3, 200e-3, "unlisted")],
)
def test_names_with_which_the_controller_holds_the_motion_worse_are_no_finding(
    fitted: float, unseen: float, verdict: str
):
    """A cubic spring and a delay, which the axis had not, halved a torque and doubled the error of the position."""
    found = replace(
        finding_that_leaves(20e-3, floor=19e-3, black_box=10e-3),
        nominal_loop=SimpleNamespace(rms={"fit": 54e-3, "validate": 169e-3}),
        final_loop=SimpleNamespace(rms={"fit": fitted, "validate": unseen}),
    )
    assert found.verdict == verdict


@pytest.mark.parametrize(
    ("doubted", "verdict"), [((), "named"), (("two",), "partly_named"), (("one", "two"), "unlisted")]
)
def test_names_stand_alone_only_where_none_is_doubted(doubted: tuple[str, ...], verdict: str):
    """A cable that no bag of stretches kept was named beside a ripple as if it were as certain."""
    found = finding_that_leaves(5e-3, floor=19e-3, black_box=10e-3)
    found.search.final.effects = tuple(
        SimpleNamespace(key=key, id=key, title=f"title of {key}") for key in ("one", "two")
    )
    found.search.study = SimpleNamespace(prismatic=False, delay=0.0, friction_by_run=None)
    found = replace(found, doubted=frozenset(doubted))
    assert found.verdict == verdict
    told = {
        "named": "Missing in the model: one (title of one) and two (title of two).",
        "partly_named": "one (title of one); they explain a part. Not certain: two (title of two).",
        "unlisted": "no name for it is certain. It is like one (title of one) and two (title of two).",
    }
    assert told[verdict] in found.sentence


@pytest.mark.parametrize(
    ("movers", "worsening", "told"),
    [
        ({"two"}, set(), "With two the inertia would be 0.73 kg instead of 24 kg. So no FMU has these effects."),
        (
            set(),
            {"two"},
            "With two a free simulation of unseen runs misses the position by 0.0435 m instead of 0.0329 m",
        ),
        ({"one", "two"}, set(), "(two). With one and two the inertia would be 0.73 kg instead"),
    ],
)
def test_what_doubts_a_name_is_told(movers: set[str], worsening: set[str], told: str):
    """A lag that an axis had not took the place of its inertia, and was told as certain."""
    found = finding_that_leaves(5e-3, floor=19e-3, black_box=10e-3)
    found.search.final.effects = tuple(SimpleNamespace(key=key, id=key, title=key) for key in ("one", "two"))
    found.search.study = SimpleNamespace(prismatic=True, delay=0.0, friction_by_run=None)
    soundness = Soundness(
        inertia=(24.0, 0.73), free=(32.9e-3, 43.5e-3), movers=frozenset(movers), worsening=frozenset(worsening)
    )
    found = replace(found, soundness=soundness, doubted=soundness.doubted)
    assert found.verdict == ("unlisted" if len(movers) == 2 else "partly_named")
    assert told in found.sentence
    assert soundness.as_json() == {
        "inertia": {"before": 24.0, "after": 0.73, "doubts": sorted(movers)},
        "free_simulation_rms": {
            "before": 32.9e-3, "after": 43.5e-3, "doubts": sorted(worsening), "identified": None,
        },
    }  # fmt: skip


@pytest.mark.parametrize(("known", "outdone"), [(12e-3, True), (30e-3, False), (None, False)])
def test_a_model_that_simulates_far_worse_than_the_identified_one_is_told(known: float | None, *, outdone: bool):
    """A lag that a geared joint with backlash had not: 55 mrad in free simulation, the identified model 12."""
    found = finding_that_leaves(5e-3, floor=1e-3, black_box=4e-3)
    found.search.final.effects = (SimpleNamespace(key="one", id="one", title="one"),)
    found.search.study = SimpleNamespace(prismatic=False, delay=0.0, friction_by_run=None)
    soundness = Soundness(inertia=(0.4, 0.41), free=(50e-3, 55e-3), known_free=known)
    found = replace(found, soundness=soundness)
    assert soundness.is_outdone is outdone
    told = "misses the position by 0.055 rad RMS, the identified model by 0.012 rad: use that one. So no FMU has these"
    assert (told in found.sentence) is outdone
    assert soundness.as_json()["free_simulation_rms"]["identified"] == known


BOX = "the best black box of position and speed"


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (0, f"error is 0.05 N m; no name closes any of it; {BOX} closes 4 % of its energy; 0.019 N m do not"),
        (1, f"error falls from 0.05 to 0.05 N m; names close 0 % of its energy, {BOX} 4 %; 0.019 N m do not"),
    ],
)
def test_an_error_that_no_name_makes_smaller_is_told_once(names: int, told: str):
    """A sentence said that an error "falls from 0.0102 to 0.0102"."""
    found = finding_that_leaves(BEFORE, floor=19e-3, black_box=49e-3, names=names)
    found.search.final.effects = (SimpleNamespace(key="one", id="one", title="one"),) * names
    found.search.study = SimpleNamespace(prismatic=False, delay=0.0, friction_by_run=None)
    assert told in found.sentence


def test_the_terminal_tells_an_error_without_names_once():
    found = finding_that_leaves(BEFORE, floor=19e-3, black_box=None, names=0)
    found.search.study = SimpleNamespace(prismatic=False, delay=0.0, friction_by_run=None)
    table = tell_finding(found, "joint 0", found.verdict)[1]
    assert isinstance(table, Table)
    assert table.rows == [("held-out torque", "0.05", "0.0001")]
    assert table.plain == "  held-out torque: RMS 0.05 N m, noise 0.0001"


def test_friction_that_differs_from_run_to_run_is_told_with_its_ends():
    found = finding_that_leaves(20e-3, floor=19e-3, black_box=30e-3)
    found.search.final.effects = (SimpleNamespace(key="one", id="one", title="one"),)
    levels = {"cold.csv": 1.1234, "middle.csv": 1.01, "warm.csv": 0.8912}
    told = RunFriction(levels=levels, before=180e-3, after=62e-3)
    found.search.study = SimpleNamespace(prismatic=False, delay=0.0, friction_by_run=told)
    assert (
        "Friction differs from run to run, from 0.891 (warm.csv) to 1.12 (cold.csv) times the model's: with it the "
        "error on held-out rows was 0.18 N m, without it 0.062 N m." in found.sentence
    )


def test_what_is_left_near_reversals_is_told():
    found = finding_that_leaves(1e-4, floor=1e-4, black_box=None, names=0)
    found.search.study = SimpleNamespace(prismatic=False)
    found.search.final.study.names = lambda _: np.array([True, True, True, False])
    found.search.final.unseen = np.array([0.1, 0.1, 0.1, 0.4])
    assert found.sentence == (
        "Nothing is missing: what is left of the torque does not repeat. Near reversals, 25 % of the rows, 0.4 N m are "
        "left: there the filter decides."
    )
