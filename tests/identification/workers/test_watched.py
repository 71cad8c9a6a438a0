"""Work in other processes says how far it is, and is the same work."""

from __future__ import annotations

import pytest

from haptid.identification.workers.watched import SHARE_OF_STAGE, Watched
from haptid.identification.workers.workers import Here, Processes, Tell, Workers, tell_nobody
from haptid.support.processes.messages import Mailbox


def climb(height: int, tell: Tell = tell_nobody) -> int:
    for step in range(height):
        tell((step + 1) / height, f"step {step + 1}")
    return height


def run(workers: Workers) -> list[tuple[float, str]]:
    told: list[tuple[float, str]] = []
    watched = Watched(workers=workers, tell=lambda share, figures: told.append((share, figures)))
    tasks = [(4,), (4,)]
    for _ in range(2):
        made = watched.until(climb, tasks, lambda done: len(tasks) - len(done), what="start")
        assert made == [4, 4]
    return told


def test_the_share_only_grows_through_tasks_and_stages():
    told = run(Here())
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0 - (1.0 - SHARE_OF_STAGE) ** 2)
    assert told[1] == (pytest.approx(SHARE_OF_STAGE / 8), "start 1 of 2, step 1")


def test_workers_of_other_processes_tell_as_well():
    with Processes(1) as pool:
        told = run(pool)
    assert any(", step" in figures for _, figures in told)
    shares = [share for share, _ in told]
    assert shares == sorted(shares)


def test_a_mailbox_takes_its_own_messages_alone():
    with Mailbox() as mailbox, Mailbox() as other:
        mailbox.sender(3)(0.5, "gain 6 1/s")
        stranger = other.sender(1)
        type(stranger)(port=mailbox.sender(0).port, token=stranger.token, task=1)(0.9, "not ours")
        (message,) = mailbox.messages()
    assert (message.task, message.share, message.figures) == (3, 0.5, "gain 6 1/s")


def test_a_message_to_nobody_is_lost_without_a_word():
    with Mailbox() as mailbox:
        sender = mailbox.sender(0)
    sender(0.5, "late")
    assert list(mailbox.messages()) == []
