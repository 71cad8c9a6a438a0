"""Findings of single joints that the model of several leaves out: they are told with the law, and with what to do."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from haptid.api.missing import Missing
from haptid.api.place import Place
from haptid.discrepancy.finding.full_model import WholeFinding
from haptid.discrepancy.job.job import Job, catalogue_without
from haptid.discrepancy.job.search import findings_below, prepare_whole, tell_other_laws
from haptid.discrepancy.search_campaign import search_campaign
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.support.errors import InputError
from haptid.support.tables import text_of

SPRING = {"id": "cubic_spring", "parameters": {"k3": {"value": 0.03, "std": 0.001}}}
LAW = {"id": "friction_law", "variant": "coulomb", "parameters": {}, "evidence": 100.0}
SAID = (
    "Left out, since it was found under another friction law than the device's: joint 5 (coulomb); "
    "state the law in the device or campaign, and identify again."
)


@pytest.fixture
def job(tmp_path: Path) -> Job:
    for joint, effect in ((4, SPRING), (5, LAW)):
        finding = {
            "schema": "discrepancy/1", "joint": joint, "measured": False, "verdict": "named", "effects": [effect],
            "refit": {"inertia": 1e-4, "k3": 0.03},
        }  # fmt: skip
        file = tmp_path / "discrepancy" / f"joint{joint}.json"
        file.parent.mkdir(exist_ok=True)
        file.write_text(json.dumps(finding))
    return Job(campaign=read_campaign(embedded_campaign()), catalogue=catalogue_without(()), out=tmp_path)


def test_one_joint_does_not_move_together_with_others() -> None:
    with pytest.raises(InputError, match="search one joint alone by --joints 3"):
        search_campaign(None, Path("out"), None, joint=None, free="3", effects=None, without="")


def test_a_finding_under_another_law_is_told_and_not_taken(job: Job) -> None:
    assert tell_other_laws(job, (3, 4, 5)) == SAID
    assert [one.joint for one in findings_below(job, (3, 4, 5))] == [4]


def test_nothing_is_told_where_every_law_stayed(job: Job) -> None:
    assert tell_other_laws(job, (0, 4)) == ""


def test_the_check_of_the_whole_device_carries_the_sentence(job: Job) -> None:
    identified = {
        "schema": "identification/1", "device": "freedom6s", "campaign": "a test", "measured": False,
        "configurations": [], "links": {},
    }  # fmt: skip
    (job.out / "identification.json").write_text(json.dumps(identified))
    assert prepare_whole(job, range(6)).left_out == SAID


def test_the_summary_ends_with_the_sentence(tmp_path: Path) -> None:
    finding = WholeFinding(joints=(4, 5), verdict="named", sentence="All is named.", names=("cubic_spring",), rows=())
    made = Missing(
        finding=finding, data={"verdict": "named", "sentence": "All is named."}, name="whole", title="all joints",
        place=Place(tmp_path), values=None, left_out=SAID,
    )  # fmt: skip
    assert text_of(made.told()).splitlines() == ["all joints: named. All is named.", f"  {SAID}"]


def test_one_joint_and_several_are_not_both_taken():
    with pytest.raises(InputError, match="expected one of --joint and --joints, got --joint 4 and --joints 4,5"):
        search_campaign(None, Path("out"), "4,5", joint=4, free=None, effects=None, without="")
