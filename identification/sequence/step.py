"""One fitted configuration of a campaign: `Step`, which sequence, summary, figures and report take in."""

from __future__ import annotations

from dataclasses import dataclass

from haptid.identification.baseline.baseline import Baseline
from haptid.identification.baseline.compared import Compared
from haptid.identification.links.consistency import Agreement
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.configurations import Configuration


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """Configuration with its fit.

    Parameters
    ----------
    configuration
        Free joints, posture of the locked ones, and runs.
    fit
        Fit of the configuration.
    torque_scored
        Whether the torque was fitted, with the measured motion as input.
    agreements
        Comparisons with earlier configurations.
    compared
        The plain model with the figures of both models; None where it was not asked for.
    device_inertia
        Inertia of a joint alone by the device's file, motor included [kg m²], [kg] for a prismatic joint; None for
        several joints, without a device, and where the campaign states another one.
    """

    configuration: Configuration
    fit: Fit
    torque_scored: bool = False
    agreements: tuple[Agreement, ...] = ()
    compared: Compared | None = None
    device_inertia: float | None = None

    @property
    def baseline(self) -> Baseline | None:
        """The plain model; None where it was not asked for, or where the fitted runs have too few rows for it."""
        return None if self.compared is None else self.compared.baseline
