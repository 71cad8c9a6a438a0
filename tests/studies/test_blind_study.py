"""A small blind study from end to end, and what keeps it honest and resumable."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from haptid.support.errors import InputError
from haptid.support.files.files import write_json
from haptid.support.processes.running import Running
from studies.blind.outcome import score_case
from studies.blind.run import main
from studies.blind.settle import with_run
from studies.blind.study import FAILED, ROOT, STAMP, Job, digest, make, work, work_all
from studies.ledger.entries import begin_study, read_ledger

ASKED = {"cases": 2, "seed": 4, "kinds": "none", "sizes": "", "inputs": "table3", "effects": ""}
FINDING = {
    "verdict": "ambiguous", "effects": [], "alternatives": [], "gap": {}, "wall_s": 1.0, "simulations": 1,
    "next_experiment": {"torque_amplitude_Nm": 0.004, "frequency_rad_s": 3.0, "torque_offset_Nm": 0.0, "tells": True},
}  # fmt: skip


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, tuple[str, ...]]:
    out, told = tmp_path_factory.mktemp("study"), list[int]()
    names = make(out, ASKED, 1, told.append)
    assert told[0] < told[-1] == len(names)
    return out, names


class Stub(Job):
    """A job whose command is a line of Python in the place of the workflow."""

    def command(self, seed: int, threads: int) -> list[str]:  # noqa: ARG002 (as the workflow's)
        return [sys.executable, "-c", LINES[self.case], str(self.out / "discrepancy"), str(self.campaign), str(seed)]


WRITE = (
    "import sys, json, pathlib; p = pathlib.Path(sys.argv[1]); p.mkdir(parents=True, exist_ok=True); "
    "f = p / 'joint3.json'; n = json.loads(f.read_text())['n'] if f.exists() else 0; "
    "f.write_text(json.dumps({'n': n + 1, 'given': sys.argv[2:]}))"
)
LINES = {
    "writes": WRITE,
    "raises": "raise SystemExit('error: no start converged')",
    "hangs": "import time; time.sleep(60)",
    "turns": "while True: pass",
    "silent": "pass",
    "stopped": "raise SystemExit(130)",
    "ended": "import os, signal; os.kill(os.getpid(), signal.SIGTERM)",
}


def job(case: str, out: Path) -> Stub:
    return Stub(case=case, campaign=Path("campaign"), out=out / case)


def test_the_workflow_is_handed_the_campaign_and_nothing_of_the_labels(study):
    out, names = study
    one = Job(case=names[0], campaign=out / "cases" / names[0], out=out / "found", without=("cogging",))
    command = one.command(7, 1)
    assert command[1:4] == ["-m", "discrepancy.run", str(out / "cases" / names[0])]
    assert command[-2:] == ["--without", "cogging"]
    assert not [part for part in command if "labels" in part]
    assert not list((out / "cases").rglob("labels*"))


def test_cases_are_made_once_and_another_study_is_refused(study):
    out, names = study
    stamps = [p.stat().st_mtime_ns for p in sorted((out / "cases").rglob("*.gz"))]
    assert make(out, ASKED, workers=1) == names == ("case_0000", "case_0001")
    assert [p.stat().st_mtime_ns for p in sorted((out / "cases").rglob("*.gz"))] == stamps
    with pytest.raises(InputError, match="another one"):
        make(out, {**ASKED, "seed": 5}, workers=1)


def test_what_cannot_be_made_is_said_in_one_line(tmp_path):
    with pytest.raises(InputError, match="--effects: expected names of the catalogue"):
        make(tmp_path, {**ASKED, "effects": "nonsense"}, workers=1)


def test_finished_cases_are_kept_until_the_code_changes(tmp_path, monkeypatch):
    one = job("writes", tmp_path)
    for stamp, seed, worked_with in (("a", 3, "3"), ("a", 4, "3"), ("b", 5, "5")):
        monkeypatch.setattr("studies.blind.study.digest", lambda stamp=stamp: stamp)
        work_all([one], seed=seed, workers=1, limit=30.0, until=float("inf"), tell=lambda: None)
        found = one.result()
        assert found == {"n": 1, "given": ["campaign", worked_with]}  # each time from an empty folder
    monkeypatch.undo()
    assert json.loads((one.out / STAMP).read_text())["code"] == "b"
    assert len(digest()) == 12


@pytest.mark.parametrize(
    ("case", "reason"),
    [
        ("raises", "exit code 1: error: no start converged"),
        ("hangs", "not finished within 4 s"),
        ("turns", "not finished within 1 s of processor time"),
        ("silent", "no result"),
    ],
)
def test_failures_are_kept_as_such(tmp_path, case, reason):
    one = job(case, tmp_path)
    work(one, Running(), seed=0, limit=1.0, stamp="a", threads=1)
    assert one.result() is None
    assert reason in str(one.failure())
    assert (one.out / FAILED).exists()


@pytest.mark.parametrize("case", ["stopped", "ended"])
def test_what_was_stopped_is_no_failure_and_is_begun_again(tmp_path, case):
    one = job(case, tmp_path)
    assert work_all([one], seed=0, workers=1, limit=9.0, until=float("inf"), tell=lambda: None) == ()
    assert not (one.out / STAMP).exists()
    assert one.failure() is None


def test_no_case_is_begun_after_the_time_is_up(tmp_path):
    told: list[int] = []
    jobs = [job("writes", tmp_path)]
    assert work_all(jobs, seed=0, workers=1, limit=9.0, until=0.0, tell=lambda: told.append(1)) == ()
    assert told == [1]
    done = job("writes", tmp_path)
    work(done, Running(), seed=0, limit=30.0, stamp=digest(), threads=1)
    again = work_all([done, job("silent", tmp_path)], seed=0, workers=1, limit=30.0, until=-1.0, tell=lambda: None)
    assert [each.case for each in again] == ["writes"]


def test_a_proposed_run_is_simulated_and_added(study):
    out, names = study
    first = Job(case=names[0], campaign=out / "cases" / names[0], out=out / "found" / names[0])
    write_json(first.out / "discrepancy" / "joint0.json", FINDING)
    labels: list[dict[str, Any]] = json.loads((out / "labels.json").read_text())["labels"]
    (settling,) = with_run(out, [score_case(labels[0], FINDING)])
    before = (out / "cases" / names[0] / "campaign.toml").read_text()
    after = (settling.campaign / "campaign.toml").read_text()
    assert after.count("[[runs]]") == before.count("[[runs]]") + 1
    assert settling.out != first.out


ORACLE = """
import json, pathlib, sys, tomllib
campaign, out = map(pathlib.Path, sys.argv[1:3])
joint = tomllib.loads((campaign / "campaign.toml").read_text())["runs"][0]["free_joints"][0]
lacks = len(sys.argv) > 3
asked = any(p.name.startswith("asked") for p in campaign.iterdir())
verdict = "unlisted" if lacks else "named" if asked else "ambiguous"
effects = [] if lacks else [{"id": "cogging", "parameters": {}}]
rivals = [] if asked or lacks else [{"ids": ["torque_ripple"], "evidence": 1.0}]
run = {"torque_amplitude_Nm": 0.004, "frequency_rad_s": 3.0, "torque_offset_Nm": 0.0, "tells": True}
found = {"verdict": verdict, "effects": effects, "alternatives": rivals, "next_experiment": run if rivals else None,
         "gap": {"validate": {"closed": 0.9}}, "wall_s": 2.0, "simulations": 5}
(out / "discrepancy").mkdir(parents=True)
(out / "discrepancy" / f"joint{joint}.json").write_text(json.dumps(found))
"""
"""A workflow that always says cogging or ripple, and cogging once a run was added."""


@pytest.mark.long
def test_a_study_goes_through_all_its_passes(tmp_path, monkeypatch):
    def command(self: Job, seed: int, threads: int) -> list[str]:  # noqa: ARG001 (as the workflow's)
        assert seed == 2
        return [sys.executable, "-c", ORACLE, str(self.campaign), str(self.out), *self.without]

    monkeypatch.setattr(Job, "command", command)
    asked = ["--cases", "2", "--kinds", "single", "--effects", "cogging", "--sizes", "small", "--inputs", "rich"]
    ledger = tmp_path / "kept" / "ledger.json"
    asked += ["--ledger", str(ledger)]
    done = CliRunner().invoke(main, ["--out", str(tmp_path), *asked, "--workers", "1", "--quiet", "--seed", "2"])
    assert done.exit_code == 0, done.output
    stored = json.loads((tmp_path / "blind.json").read_text())
    assert stored["results"] == {"among_alternatives": 2}
    assert stored["leave_one_out"]["flagged"]["hits"] == 2
    assert stored["settled_by_one_run"]["settled"]["hits"] == 2
    assert stored["right"]["share"] == 1.0
    assert stored["asked"]["effects"] == "cogging"
    assert (tmp_path / "blind.md").exists()
    (entry,) = read_ledger(ledger)
    assert (entry["outcome"], entry["worked_through"], entry["entered"]) == ("complete", 2, "before")
    assert json.loads((ledger.parent / entry["file"]).read_text()) == stored
    options = ["--workers", "1", "--quiet", "--seed", "2", "--no-whole", "--minutes", "5"]
    alone = CliRunner().invoke(main, ["--out", str(tmp_path), *asked, *options])
    assert alone.exit_code == 0, alone.output
    stored = json.loads((tmp_path / "blind.json").read_text())
    assert stored["cases"] == []
    assert stored["leave_one_out"]["flagged"]["hits"] == 2
    again = CliRunner().invoke(main, ["--out", str(tmp_path), *asked, "--workers", "1", "--quiet", "--minutes", "0"])
    assert again.exit_code == 2  # another seed is another study
    assert [e["plan"]["passes"] for e in read_ledger(ledger)] == [["found", "without", "settled"], ["without"]]


@pytest.mark.long
def test_an_interrupted_study_stays_in_the_ledger_with_what_it_worked_through(tmp_path, monkeypatch):
    stop = "import os, signal; os.kill(os.getppid(), signal.SIGINT)"

    def command(self: Job, seed: int, threads: int) -> list[str]:  # noqa: ARG001 (as the workflow's)
        ledger = json.loads((tmp_path / "ledger.json").read_text())
        assert [entry["outcome"] for entry in ledger["studies"]] == ["begun"]
        asked = [sys.executable, "-c", ORACLE, str(self.campaign), str(self.out), *self.without]
        return asked if self.case == "case_0000" else [sys.executable, "-c", stop]

    monkeypatch.setattr(Job, "command", command)
    out, ledger = tmp_path / "out", tmp_path / "ledger.json"
    asked = ["--cases", "2", "--kinds", "single", "--effects", "cogging", "--sizes", "small", "--inputs", "rich"]
    asked += ["--out", str(out), "--ledger", str(ledger), "--workers", "1", "--quiet"]
    # A background job inherits that it is ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        done = CliRunner().invoke(main, asked)
    finally:
        signal.signal(signal.SIGINT, before)
    assert done.exit_code == 130, done.output
    (entry,) = read_ledger(ledger)
    assert (entry["outcome"], entry["worked_through"]) == ("interrupted", 1)
    stored = json.loads((tmp_path / entry["file"]).read_text())
    assert [case["case"] for case in stored["cases"]] == ["case_0000"]
    (begun,) = read_ledger(ledger)
    name = begin_study(
        ledger, out, begun["plan"], {k: begun[k] for k in ("command", "date", "git", "code", "generator")}
    )
    assert name == begun["id"]
    assert len(read_ledger(ledger)[0]["given_again"]) == 1


def _is_empty(group: int) -> bool:
    """Whether a group has no process any more: what has ended stays in it until the system takes note, which takes it
    a moment.
    """
    until = time.monotonic() + 20.0
    while time.monotonic() < until:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="process groups are POSIX's")
@pytest.mark.long
def test_a_terminated_study_leaves_nothing_running_and_goes_on(tmp_path):
    """As ``timeout`` or a batch system ends it: the signal goes to the study alone, not to what it started."""
    command = [sys.executable, "-m", "studies.blind.run", "--cases", "6", "--kinds", "none", "--inputs", "table3"]
    command += ["--out", str(tmp_path), "--workers", "2", "--minutes", "30", "--quiet"]
    command += ["--ledger", str(tmp_path / "ledger.json")]
    study = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True, start_new_session=True)
    until = time.monotonic() + 400.0  # the first case takes 20 s where nothing else runs
    while not list(tmp_path.glob("found/*")) and time.monotonic() < until:
        time.sleep(0.1)
    assert list(tmp_path.glob("found/*"))
    study.send_signal(signal.SIGTERM)
    _, said = study.communicate(timeout=60.0)
    assert (study.returncode, said) == (143, "interrupted: what was finished is kept\n")
    assert _is_empty(study.pid)
    assert not list(tmp_path.glob("found/*/failed.json"))
    (entry,) = read_ledger(tmp_path / "ledger.json")
    assert entry["outcome"] == "interrupted"
