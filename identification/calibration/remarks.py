"""What an FMU's description says against its use in a campaign: both in, sentences out, which end no calibration."""

from __future__ import annotations

import numpy as np

from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.foreign_campaign import ForeignCampaign
from haptid.support.errors import one_line


def remarks_on(campaign: ForeignCampaign, fmu: ForeignFmu) -> tuple[str, ...]:
    """Say what the FMU's description breaks of the standard, and whether the runs ask for what it does not promise.

    Parameters
    ----------
    campaign
        Campaign about the FMU.
    fmu
        The FMU, unpacked.

    Returns
    -------
    tuple of str
        A sentence each; empty where there is nothing to say.
    """
    said = []
    if rules := fmu.broken_rules:
        others = f" (and {len(rules) - 1} more)" if len(rules) > 1 else ""
        first = one_line(rules[0]).rstrip(".")
        said.append(
            "the FMU's modelDescription.xml breaks the FMI standard, and hosts that validate refuse it: "
            f"{first}{others}"
        )
    uneven = [run.file for run in campaign.runs if run.use != "excluded" and _is_uneven(run.t)]
    if uneven and fmu.interface == "CoSimulation" and not _takes_any_step(fmu):
        others = f" (and {len(uneven) - 1} more)" if len(uneven) > 1 else ""
        said.append(
            f"the rows of {uneven[0]}{others} are not evenly spaced, and the FMU does not promise to take steps of "
            "different length (canHandleVariableCommunicationStepSize): compare with evenly spaced rows"
        )
    return tuple(said)


def _takes_any_step(fmu: ForeignFmu) -> bool:
    return str(fmu.description.coSimulation.canHandleVariableCommunicationStepSize).lower() in ("true", "1")


def _is_uneven(t: np.ndarray) -> bool:
    steps = np.diff(t)
    return bool(steps.size and np.ptp(steps) > THRESHOLDS.largest_spread_of_even_steps * np.median(steps))
