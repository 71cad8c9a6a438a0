"""The command ``haptid report``, which is ``python -m report.run``, declared without its work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.support.command import exit_codes
from haptid.support.declaring.declaration import call, command, json_option

EXAMPLES = """
haptid report results
haptid report results --json
"""


@command(EXAMPLES, writes={})
@click.argument("results", type=click.Path(path_type=Path), default=Path("artifacts"))
@exit_codes
@json_option
def report(**settings: Any) -> Any:
    """Write the pages in RESULTS again, from what is stored there and without fitting.

    RESULTS is the folder that --out of the other commands named (default artifacts). Written are report.html,
    posterior.html, locking_plan.html and discrepancy/*.html, from their content in the folders named pages: after a
    page was lost, or to give it the looks of this version. A result without such
    content gets a page of its tables alone where it has none, and is named on stderr with the command that makes the
    page with pictures.
    """
    return call("haptid.report.run", "render_again", **settings)
