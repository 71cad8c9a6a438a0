"""The gap between data and model: RMS before and after the named effects in, share of the excess removed out."""

from __future__ import annotations

from dataclasses import dataclass

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS


def tell_share(share: float | None, decimals: int = 1) -> str:
    """Tell a closed share in per cent.

    Parameters
    ----------
    share
        Share [1]; None where there is none. What is left can lie below the noise that was stated or estimated, which
        makes the quotient more than 1: no more than all of a gap can be closed.
    decimals
        Decimals of the number.

    Returns
    -------
    str
    """
    return "–" if share is None else f"{100 * min(share, 1.0):.{decimals}f} %"


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """RMS of measured − simulated over some runs, before and after the named effects.

    Parameters
    ----------
    before, after
        RMS of the nominal and of the best model [rad], [m] for a prismatic joint; [N m] where the torque is scored.
    noise
        RMS of the sensor noise in the same unit.
    beside
        Where amplitudes scatter: RMS of the whitened residuals before and after, which is 1 for noise and scatter
        alone. No model could remove the part that scatter causes.
    """

    before: float
    after: float
    noise: float
    beside: tuple[float, float] | None = None

    @property
    def closed(self) -> float | None:
        """Share of the excess RMS that is removed, (before − after)/(before − noise); None without excess."""
        excess = self.before - self.noise
        if excess < THRESHOLDS.finding.least_excess_over_noise * self.noise:
            return None
        return (self.before - self.after) / excess

    @property
    def closed_beside_scatter(self) -> float | None:
        """Same share beside the scatter, (before − after)/(before − 1) of ``beside``; `closed` without scatter.

        `closed` counts as well where the RMS grows by what noise and scatter do not explain, since whitened by a large
        scatter the rest says little, and where the scatter takes more than the noise: whitened residuals then fall well
        below 1 and their share above all.
        """
        if self.beside is None:
            return self.closed
        before, after = self.beside
        limits = THRESHOLDS.finding
        if after > limits.largest_rms_as_scatter and self.after > limits.largest_share_beside_scatter * self.before:
            return self.closed
        if before < limits.largest_rms_as_scatter:
            return None
        share = (before - after) / (before - 1.0)
        return min(share, 1.0) if share <= limits.largest_share_beside_scatter else self.closed

    def as_json(self) -> dict[str, float | None]:
        """Convert to an entry of ``gap`` in the finding's JSON.

        Returns
        -------
        dict
            ``before``, ``after`` and ``noise`` in the fields' unit, the shares ``closed`` and ``closed_beside_scatter``
            [1]; ``floor`` and ``black_box``, which only a search in torque knows, are None.
        """
        return {
            "before": self.before, "after": self.after, "noise": self.noise, "closed": self.closed,
            "closed_beside_scatter": self.closed_beside_scatter, "floor": None, "black_box": None,
        }  # fmt: skip
