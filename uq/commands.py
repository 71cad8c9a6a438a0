"""The command ``haptid posterior``, which is ``python -m uq.run``, declared without its work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.identification.foreign.options import limit_option
from haptid.measurement.format.embedded import embedded_option
from haptid.measurement.format.places import allow_outside_option
from haptid.support.command import common_options, exit_codes
from haptid.support.declaring.declaration import call, command, json_option

EXAMPLES = """
haptid posterior my_campaign --out results
haptid posterior my_campaign --joints 4 --quick --out results
haptid posterior my_campaign --out results --json | jq '.joints[0].parameters'
"""
WRITES = {
    "posterior.json": "medians, intervals, diagnostics",
    "posterior.html": "predictive bands, intervals, noise model",
    "posterior/joint<j>.nc": "the chains, which ArviZ reads",
    "parameters_posterior.csv": "draws of all parameters, one a row",
}


@command(EXAMPLES, WRITES)
@click.argument("campaign", required=False, type=click.Path(path_type=Path))
@common_options
@click.option(
    "--quick",
    is_flag=True,
    help="Short climbs to choose the noise model, and a short chain, which says that it is short.",
)
@click.option("--sensitivity", is_flag=True, help="Also with all priors half and twice as wide.")
@click.option(
    "--fmu",
    "kind",
    type=click.Choice(["python", "native", "none"]),
    default="none",
    show_default=True,
    help="Packaging that the sampler runs; none runs the same equations' kernel in process, many sets side by side.",
)
@limit_option
@allow_outside_option
@exit_codes
@embedded_option
@json_option
def posterior(**settings: Any) -> Any:
    """Sample the posterior of every joint's parameters in CAMPAIGN, which says how well each is known.

    CAMPAIGN is a folder with campaign.toml; the embedded Freedom 6S one where left out. It goes on from the fits that
    haptid identify left below --out, and makes its own where there are none. A joint takes minutes, and more
    where its model leaves much more than the noise: the progress says how long is left, the chains end after 5000 steps
    at most. --quick is for a first look: it bounds what the chains simulate, and says so where many or fast rows leave
    fewer ensembles and steps; to choose the noise model takes longer the more rows there are. Of a calibrated FMU,
    CAMPAIGN is the folder of the results.

    Units: rad, N m, kg m² (m, N, kg for a joint that slides), s.
    """
    return call("haptid.uq.sample_campaign", "sample_campaign", **settings)
