"""The part of a torque that the filter of inverse dynamics takes away: campaign in, RMS out.

The search for missing effects scores torques after two passes of a low-pass filter; published residuals are those of
the recorded torque. The filter's pass band and what it takes away do not overlap, so that the squares of both add up.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from haptid.identification.sequence.configurations import configurations_of
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.signals.filtered_motion import filter_run


def filtered_away(campaign: Path, use: str) -> float:
    """Return the RMS of recorded minus twice filtered torque over the runs of one use [N m] of a single joint."""
    read = campaign_for_command(campaign)
    parts = []
    for run in configurations_of(read, None)[-1].runs:
        if run.use == use:
            motion = filter_run(run)
            recorded = np.interp(motion.t, run.t, run.u[:, 0])
            parts.append((recorded - motion.through_filter(motion.torque)[:, 0])[motion.interior])
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
