"""Published values of the two-joint arm, simulated as haptid simulates what it identified."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.observer import Observed
from haptid.identification.statistics.score import score
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.run import Array

G = 9.81
"""Gravity [m/s²]."""
PUBLISHED = {
    "l1": 0.3, "I1": 0.0535, "I2": 0.0239, "m1": 0.559, "m2": 0.604, "r1": 0.3, "r2": 0.184, "rotor": 7.66e-5,
    "ratio": 6.0, "Fc_0": 0.093, "Fc_1": 0.078, "sigma2_0": 0.001,
}  # fmt: skip
"""SI units; friction is Fc·atan(100·v) + sigma2·v."""


class Values:
    """Parameters alone, for `score`."""

    def __init__(self, theta: Array) -> None:
        self.theta = theta


def published_combinations() -> dict[str, float]:
    """Return the published values as the parameters of the coupled equations."""
    p = PUBLISHED
    rotor = p["rotor"] * p["ratio"] ** 2
    return {
        "M00_1": p["I1"] + p["I2"] + p["m2"] * p["l1"] ** 2 + rotor + p["rotor"],
        "M00_c1": 2 * p["m2"] * p["l1"] * p["r2"],
        "M11_1": p["I2"] + rotor,
        "V_c0": -(p["m1"] * p["r1"] + p["m2"] * p["l1"]) * G,
        "Fc_0": p["Fc_0"] * np.pi / 2,
        "Fc_1": p["Fc_1"] * np.pi / 2,
        "sigma2_0": p["sigma2_0"],
    }


def published_scores(campaign: Path, gain: float) -> dict[str, float]:
    """Return RMS over noise by run that the published values leave, through an observer of gain [1/s] where it is > 0.

    The published friction has neither stiction nor bristles: these keep the first guesses.
    """
    read = campaign_for_command(campaign)
    equations = equations_for(read, device_of(read), (0, 1))
    theta = np.array([published_combinations().get(q.id, q.initial) for q in equations.parameters])
    kernel = KernelSimulator.of(equations)
    simulator = Observed(kernel, gain) if gain > 0 else kernel
    return {run.file: score(simulator, Values(theta), run).over_noise for run in read.runs if run.use != "excluded"}
