"""Say where the fit of an effect begins: effect and its `Score` in, start values of its parameters out."""

from __future__ import annotations

from collections.abc import Sequence

from haptid.discrepancy.detect.score_tests import Score
from haptid.discrepancy.detect.signatures import Point
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect


def start_values(effect: Effect, point: Point, amplitude: Sequence[float]) -> dict[str, float]:
    """Return start values of an effect at a scored shape.

    Parameters
    ----------
    effect
        Effect in SI units.
    point
        Shape of the effect.
    amplitude
        Linear estimate of the factor on each column's amplitude.

    Returns
    -------
    dict
        Parameters by id, within their bounds.
    """
    ids = [q.id for q in effect.parameters[: effect.amplitudes]]
    values = dict(point.values[0])
    # One column for several amplitudes means that the grid itself holds the amplitudes.
    if len(point.values) == 1 and effect.amplitudes > 1:
        return values
    for k, (id, factor) in enumerate(zip(ids, amplitude, strict=True)):
        values[id] = point.values[k][id] * factor
    return {q.id: min(max(values[q.id], q.lower), q.upper) for q in effect.parameters}


def starts_of(effect: Effect, score: Score) -> list[dict[str, float]]:
    """Return the start values from which a catalogue effect is fitted through homotopy.

    Effects that are not linear in their amplitude (a delay, a play, a compliance) may have a score of 0 though they are
    large, so the fit also begins at the largest amplitude of their grid.

    Parameters
    ----------
    effect
        Effect in SI units.
    score
        Best score of the effect.

    Returns
    -------
    list of dict
        One or two sets of parameters by id.
    """
    scored = start_values(effect, score.point, no_larger(score.amplitude, 1.0))
    amplitudes = [q.id for q in effect.parameters[: effect.amplitudes]]
    largest = {id: grid[-1] for id, grid in effect.shapes if id in amplitudes}
    if not largest:
        return [scored]
    return [*([scored] if score.T > 0.0 else []), scored | largest]


def near(effect: Effect, amplitude: Sequence[float]) -> list[float]:
    """Scale a linear estimate of the amplitudes down to where a fit may begin.

    The linear estimate gives the size of the effect once the nominal model has moved along. With the nominal model
    where it is, a large effect is far from the readings. An effect with amplitudes alone reaches its size in the first
    step of the fit, together with the nominal model, and so begins small. A shape parameter does not move where the
    amplitude is small.

    Parameters
    ----------
    effect
        Effect in SI units.
    amplitude
        Factors on the effect's typical size.

    Returns
    -------
    list of float
        Factors of the same ratio, at most `largest_start_size_without_shape` without shape parameters and
        `largest_start_size` with them.
    """
    free = sum(not x.fixed for x in effect.parameters)
    if free == effect.amplitudes and not effect.shapes:
        return no_larger(amplitude, THRESHOLDS.candidate.largest_start_size_without_shape)
    return no_larger(amplitude, THRESHOLDS.candidate.largest_start_size)


def no_larger(amplitude: Sequence[float], largest: float) -> list[float]:
    """Scale factors down in common until none exceeds a limit.

    Parameters
    ----------
    amplitude
        Factors on the effect's typical size.
    largest
        Largest magnitude of a factor.

    Returns
    -------
    list of float
        Factors of the same ratio.
    """
    factor = min(1.0, largest / max(*map(abs, amplitude), 1e-300))
    return [a * factor for a in amplitude]
