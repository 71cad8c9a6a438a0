"""Cosine torques of the locked-joint tests: Table III of Tam, Kubica and Wang (2005), and a richer set."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from haptid.support.errors import InputError
from haptid.virtual_device.machine.compiled import Array

BRACKETED = "non-uniform system behaviour: bracketed in Table III of the paper"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cosine:
    """Torque of one run, o + A cos(φ), and what the run is for.

    Parameters
    ----------
    amplitude, offset
        A and o [N m].
    frequency, end_frequency
        φ = ω t with the frequency ω [rad/s]; where there is an end frequency Ω, dφ/dt = ω (Ω/ω)^(t/duration) [rad/s].
    use, reason
        Use of the run in campaign.toml, and why it is excluded.
    duration, spacing
        Length of the run and distance of its rows [s].
    """

    amplitude: float
    frequency: float
    use: str = "fit"
    reason: str = ""
    duration: float = 20.0
    spacing: float = 0.005
    offset: float = 0.0
    end_frequency: float | None = None

    @property
    def period(self) -> float:
        """Length of a cycle [s]."""
        return 2 * np.pi / self.frequency

    def times(self) -> Array:
        """Space the rows of the run.

        Returns
        -------
        ndarray, shape (n_t,)
            Times [s] from 0 to ``duration``, rounded to 1 µs.
        """
        return np.round(np.arange(round(self.duration / self.spacing) + 1) * self.spacing, 6)

    def torque(self) -> Array:
        """Compute the torque at the rows, rounded as the table holds it.

        Returns
        -------
        ndarray, shape (n_t,)
            Torque [N m].
        """
        phase = self.frequency * self.times()
        if self.end_frequency not in (None, self.frequency):
            ratio = self.end_frequency / self.frequency
            phase = phase[-1] * (ratio ** (self.times() / self.duration) - 1) / np.log(ratio)
        return np.asarray(np.round(self.offset + self.amplitude * np.cos(phase), 8))


AMPLITUDE = (0.020, 0.015, 0.020, 0.008, 0.005, 0.008)
"""Torque amplitude of each joint in Table III [N m]."""
COUPLED = (
    ((1.33, 1.00), "fit"),
    ((1.65, 1.42), "fit"),
    ((1.00, 1.83), "fit"),
    ((1.20, 1.62), "validate"),
)
"""Frequencies of joints 0 and 1 in the coupled test [rad/s]."""
_FIT: tuple[tuple[float, ...], ...]
_FIT = ((1.0, 1.33, 1.65), (1.0, 1.21, 1.42, 1.62), (1.0, 1.5, 2.0), (0.5, 0.88, 1.63, 2.0), (0.5, 1.13, 1.75, 2.38))
_FIT += ((0.5, 1.0, 2.0, 2.5),)
_VALIDATE = (1.975, 1.83, 2.3, 1.25, 3.0, 1.5)
_EXCLUDED: tuple[tuple[float, ...], ...] = ((2.3,), (), (2.5,), (), (), ())


def table3(joint: int) -> tuple[Cosine, ...]:
    """Return the runs of Table III for ``joint``, in the order of frequency.

    Brackets are validation runs or excluded; joints without brackets keep their middle frequency for validation.

    Parameters
    ----------
    joint
        Number of the joint, 0 to 5.

    Returns
    -------
    tuple of Cosine
        One cosine a run.

    Raises
    ------
    InputError
        Where there is no such joint.
    """
    _check(joint)
    made = [Cosine(amplitude=AMPLITUDE[joint], frequency=w) for w in _FIT[joint]]
    made.append(Cosine(amplitude=AMPLITUDE[joint], frequency=_VALIDATE[joint], use="validate"))
    left_out = Cosine(amplitude=AMPLITUDE[joint], frequency=1.0, use="excluded", reason=BRACKETED)
    made += [replace(left_out, frequency=w) for w in _EXCLUDED[joint]]
    return tuple(sorted(made, key=lambda run: run.frequency))


_RICH_FIT = ((1.0, 0.60), (0.6, 1.10), (1.3, 0.90), (0.8, 1.70), (1.1, 1.40), (0.7, 2.20), (1.2, 2.0), (0.9, 0.45))
_RICH_VALIDATE = ((1.15, 1.25), (0.75, 1.90), (0.95, 0.75))


def rich(joint: int, amplitude: float | None = None) -> tuple[Cosine, ...]:
    """Return eight cosines to fit and three to validate, of 16 s, all of different amplitude and frequency.

    Parameters
    ----------
    joint
        Number of the joint, 0 to 5; not used where ``amplitude`` is given.
    amplitude
        Torque amplitude to vary about [N m]; that of Table III where None.

    Returns
    -------
    tuple of Cosine
        The cosines to fit, then those to validate.

    Raises
    ------
    InputError
        Where there is no such joint.
    """
    if amplitude is None:
        _check(joint)
        amplitude = AMPLITUDE[joint]
    shared = Cosine(amplitude=amplitude, frequency=1.0, duration=16.0, spacing=0.01)
    fitted = [replace(shared, amplitude=round(amplitude * a, 8), frequency=w) for a, w in _RICH_FIT]
    unseen = [replace(shared, amplitude=round(amplitude * a, 8), frequency=w) for a, w in _RICH_VALIDATE]
    return (*fitted, *(replace(run, use="validate") for run in unseen))


def _check(joint: int) -> None:
    if joint not in range(6):
        raise InputError(where="joint", expected="0 to 5", got=str(joint))
