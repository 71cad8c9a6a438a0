"""The commands that belong to no package, declared without their work: ``haptid doctor``."""

from __future__ import annotations

from typing import Any

from haptid.support.command import exit_codes
from haptid.support.declaration import call, command, json_option

EXAMPLES_OF_DOCTOR = """
haptid doctor
haptid doctor --json
"""


@command(EXAMPLES_OF_DOCTOR, writes={})
@exit_codes
@json_option
def doctor() -> Any:
    """Check whether this installation can work, one line a check, each with what to do about a problem.

    Checked are Python, the required packages, the compiler, the cache (HAPTID_CACHE) and its disk, the optional extras,
    that a kernel compiles and that an FMU loads and runs: both are made anew in a temporary folder of the cache, which
    takes up to a minute. Exit code 1 where something is missing; an optional extra that is absent is not.
    """
    return call("haptid.doctor", "examine")
