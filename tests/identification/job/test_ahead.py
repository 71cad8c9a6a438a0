"""Compilation ahead of need: what is waited for, what is dropped, and for which jobs there is any."""

import threading
from dataclasses import replace

import pytest

from haptid.identification.job.ahead import Ahead, compilations_of
from haptid.identification.job.job import Job
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import configurations_of
from haptid.measurement.format.devices import device_of
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.reading import read_campaign


def test_a_running_task_is_waited_for_and_a_later_one_is_dropped():
    go, begun, done = threading.Event(), threading.Event(), []

    def slow():
        begun.set()
        assert go.wait(60)
        done.append("slow")

    with Ahead([slow, lambda: done.append("late"), lambda: done.append("last")]) as ahead:
        assert begun.wait(60)
        ahead.wait(1)  # not begun: dropped, and not waited for
        assert done == []
        go.set()
        ahead.wait(0)
        assert "slow" in done
        ahead.wait(7)  # there is none
    assert "late" not in done


def test_a_task_that_fails_is_left_to_the_stage_that_needs_it():
    with Ahead([lambda: 1 / 0]) as ahead:
        ahead.wait(0)


@pytest.fixture
def job(tmp_path):
    campaign = read_campaign(embedded_campaign())
    device = device_of(campaign)
    return Job(
        campaign=campaign, device=device, configurations=configurations_of(campaign, device, (4, 5)),
        options=FitOptions(workers=2), kind=None, out=tmp_path, scheduler=None, made_by="a test",
    )  # fmt: skip


def test_each_configuration_and_the_whole_device_are_compiled_ahead(job):
    assert len(compilations_of(job)) == len(job.configurations) + 1


def test_nothing_is_compiled_ahead_by_one_worker_or_for_single_joints(job):
    assert compilations_of(replace(job, options=FitOptions(workers=1))) == []
    assert compilations_of(replace(job, scheduler="tcp://somewhere:1")) == []
    assert compilations_of(replace(job, device=None)) == []
