"""ArviZ keeps a stamp of its daily announcement, which two processes that begin at the same moment move at once."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

RACE = """
import pathlib
replace, lost = pathlib.Path.replace, []
def racing(self, target):
    if self.name == "daily_warning.tmp" and not lost:
        lost.append(replace(self, target))  # the other process
    return replace(self, target)
pathlib.Path.replace = racing
import uq.result.arviz_door
assert lost, "the race was not run"
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the folder of the stamp is named by XDG_CACHE_HOME on Linux alone")
def test_a_stamp_that_another_process_moved_stops_no_import(tmp_path: Path):
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", RACE], env=environment, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
