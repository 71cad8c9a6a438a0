"""Bounds that haptid chose: a fit that ends on one of them is repeated with a wider range.

The range of a parameter that neither user nor device states is a guess. An optimum on its end is a statement about the
guess, not about the joint, so that nothing is said before the range is wider. Two ends stay: what a file may state
(`possible_range`), for a result is read again, and for stiction the torque that acted on the joint, which moved.

1. Find the parameters at an end of their range that nobody stated and that physics does not set (`wider_ranges`).
2. Widen these ranges and fit again, from the optimum alone.
3. Keep the new fit where its cost is lower, and start again with it.
4. Otherwise the data do not determine the parameter beyond the old end: it becomes ``unidentifiable``, with a sentence.
5. Where a fit that was kept from one start is above the noise, let other starts say whether it is the best minimum. At
   the noise the starts of the first fit, from whose minimum it came, have said so. Where the error of the inner step
   shows beside the residual, other starts would compare that error: the finer step is asked first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from haptid.identification.fit.multistart import from_optimum, with_agreement
from haptid.identification.fit.strategy import quiet
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.result.fit import Fit
from haptid.identification.statistics.identifiability import on_bound
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Run
from haptid.model.device.stated_parameters import possible_guess
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.registry import law_named
from haptid.support.numbers import plain

FitEquations = Callable[[Equations, FitOptions], Fit]
"""Function that fits equations, with the bounds they hold, under some options."""


def fit_within_own_bounds(  # what is fitted, on which rows, within which ranges, and what is asked of it
    fit_equations: FitEquations,
    equations: Equations,
    runs: Sequence[Run],
    own: Sequence[str],
    options: FitOptions,
    *,
    needs_finer_step: Callable[[Fit], bool] | None = None,
) -> Fit:
    """Fit, and widen ranges that haptid chose as long as the optimum lies on them and the cost falls.

    Parameters
    ----------
    fit_equations
        Function that fits equations.
    equations
        Equations with the first ranges.
    runs
        Runs of the fit; those with ``use == "fit"`` count.
    own
        Ids of the parameters whose range haptid chose.
    options
        Choices of the first fit; the repeated ones start at its optimum.
    needs_finer_step
        Whether the inner step of a fit is too long for its residual, so that it will be repeated at a finer one; no
        step is where None.

    Returns
    -------
    Fit
        Its equations hold the ranges that it was made with.
    """
    first = found = fit_equations(equations, options)
    widened = False
    open_ends: tuple[str, ...] = ()
    for _ in range(THRESHOLDS.most_widenings_of_bounds):
        wider = wider_ranges(found, own, runs)
        if not wider:
            break
        ranged = equations.with_parameters(wider)
        # From a minimum one start takes a tenth of the time of all of them, and lowers the cost wherever the range
        # alone held it.
        again = fit_equations(ranged, from_optimum(found, options, alone=True))
        if not _better(again, found, runs):
            open_ends = tuple(wider)
            break
        found, equations, widened = again, ranged, True
    # Within a wider range the motion may be followed without the observer, on the way of all gains.
    free = found.observer_gain == options.gains[-1]
    if widened and free and (quiet(found, options) or (needs_finer_step is not None and needs_finer_step(found))):
        found = with_agreement(found, first, options)
    elif widened and (options.starts > 1 or len(options.gains) > 1):  # else it would be the same fit once more
        everywhere = fit_equations(equations, from_optimum(found, options))
        found = found if _better(found, everywhere, runs) else everywhere
    found = _tell_open_ends(found, open_ends) if open_ends else found
    return _tell_stiction_beyond_torque(found, own, runs)


def wider_ranges(found: Fit, own: Sequence[str], runs: Sequence[Run]) -> dict[str, dict[str, object]]:
    """Widen the ranges at whose ends the estimates lie.

    Parameters
    ----------
    found
        Fit whose equations hold the ranges.
    own
        Ids of the parameters whose range haptid chose.
    runs
        Runs of the fit, whose torques bound stiction.

    Returns
    -------
    dict
        First guess (the estimate), ``lower`` and ``upper`` by id. An end at 0 of a quantity that cannot be negative
        stays, and so does the range of a spring's equilibrium where there is no spring. No range is wider than a file
        may state, and that of stiction ends at a multiple of the torque that acted on the joint.
    """
    parametrisation = Parametrisation.of(found.equations)
    s = parametrisation.to_coordinates(found.theta)
    result: dict[str, dict[str, object]] = {}
    for quantity, edge in zip(parametrisation.quantities, on_bound(parametrisation, s), strict=True):
        value = found.values[quantity.id]
        if edge and quantity.id in own and not _is_of_absent_spring(quantity.id, found):
            lower, upper = _widen_range(quantity, value)
            if (place := _stictions(found).get(quantity.id)) is not None:
                most = THRESHOLDS.largest_stiction_over_torque * _largest_torque(found, runs, place)
                upper = min(upper, max(most, quantity.upper))
            wider = possible_guess(quantity.id, value, lower, upper)
            if (wider["lower"], wider["upper"]) != (quantity.lower, quantity.upper):
                result[quantity.id] = wider
    return result


def _stictions(found: Fit) -> dict[str, int]:
    """Return the place of the joint among the free ones by the id of its stiction.

    The torque equation of a joint has none: its input is the motion, and no torque bounds stiction there.
    """
    if not found.equations.joints:
        return {}
    laws = zip(found.equations.friction, id_suffixes(found.equations.joints), strict=True)
    return {f"{law_named(law).roles.stiction}{suffix}": k for k, (law, suffix) in enumerate(laws)}


def largest_command(equations: Equations, runs: Sequence[Run], place: int | None = None) -> float:
    """Return the largest torque that fitted runs command.

    Parameters
    ----------
    equations
        Equations of the configuration.
    runs
        Runs of the fit; those with ``use == "fit"`` count.
    place
        Place of the joint among the free ones; all of them count where None.

    Returns
    -------
    float
        In N m, or N; infinite for a drive, whose command is no torque, and without such runs.
    """
    if equations.drive is not None:
        return np.inf
    columns = slice(None) if place is None else place
    return max((float(np.abs(run.u[:, columns]).max()) for run in runs if run.use == "fit"), default=np.inf)


def _largest_torque(found: Fit, runs: Sequence[Run], place: int) -> float:
    """Return the most that command and gravity made together at a joint [N m]; infinite where the command tells none.

    The potential energy of a coupled joint has the gravity of all of them.
    """
    command = largest_command(found.equations, runs, place)
    if np.isinf(command):
        return command
    single = len(found.equations.joints) == 1
    weights = [id for id in found.values if (id.startswith("gravity_") if single else id.startswith("V_"))]
    gain = "Kp" if single else f"Kp_{found.equations.joints[place]}"
    return found.values.get(gain, 1.0) * command + sum(abs(found.values[id]) for id in weights)


def _widen_range(quantity: Quantity, value: float) -> tuple[float, float]:
    """Widen a range on the side of the value."""
    lower, upper = quantity.lower, quantity.upper
    low = abs(value - lower) < abs(upper - value)
    if quantity.scale == "log":
        factor = THRESHOLDS.bounds_over_guess
        # Nearer by ratio: the range of a logarithm spans orders of magnitude.
        low = value / lower < upper / value
        return (lower / factor, upper) if low else (lower, upper * factor)
    reach = THRESHOLDS.widening_of_linear_range * (upper - lower)
    if not low:
        return lower, upper + reach
    # A range that begins at 0 is that of a quantity that cannot be negative.
    return (lower if lower == 0.0 else lower - reach), upper


def _is_of_absent_spring(id: str, found: Fit) -> bool:
    """Whether a parameter is the equilibrium of a spring whose stiffness lies on 0."""
    spring = id.replace("epos", "Ks")
    return spring != id and spring in found.statuses and found.statuses[spring] != "identified"


def _better(again: Fit, found: Fit, runs: Sequence[Run]) -> bool:
    """Whether the cost fell by more than two starts of one minimum differ."""
    if again.observer_gain != found.observer_gain:
        # A free simulation is the stricter test: what the observer leaves is no measure of it.
        return again.observer_gain < found.observer_gain
    rows = sum(run.y.size for run in runs if run.use == "fit") * float(np.mean(FitOptions().weights))
    least = max(
        THRESHOLDS.largest_cost_difference_in_basin / rows,
        THRESHOLDS.largest_relative_cost_difference_in_basin * found.cost,
    )
    return found.cost - again.cost > least


def _tell_open_ends(found: Fit, ids: Sequence[str]) -> Fit:
    """Say of parameters at an end of their range that a wider range changes nothing."""
    stiff = [law_named(law).roles.stiffness for law in found.equations.friction]
    said = []
    for id in ids:
        quantity = found.equations.parameter(id)
        value = f"{id} = {plain(found.values[id], 3)} {quantity.unit}"
        if id.split("_")[0] in stiff and found.values[id] > quantity.initial:
            said.append(f"presliding is too stiff to be seen: from {value} on, a stiffer one gives the same motion")
        else:
            said.append(f"{value} is the end of its range, and a wider range fits no better: the runs leave it open")
    statuses = {id: "unidentifiable" if id in ids else status for id, status in found.statuses.items()}
    return found.but(statuses=statuses, warnings=(*found.warnings, *said))


def _tell_stiction_beyond_torque(found: Fit, own: Sequence[str], runs: Sequence[Run]) -> Fit:
    """Say of stiction at the end of its range, beyond every torque of the runs, that they do not tell it."""
    statuses, said = dict(found.statuses), list(found.warnings)
    for id, place in _stictions(found).items():
        largest = _largest_torque(found, runs, place)
        if id in own and statuses[id] == "at_bound" and found.values[id] > largest:
            unit = found.equations.parameter(id).unit
            statuses[id] = "unidentifiable"
            said.append(
                f"{id} = {plain(found.values[id], 3)} {unit} is more than all that acted on the joint, "
                f"{plain(largest, 3)} {unit}: the joint moved, and these runs do not tell its stiction"
            )
    return found.but(statuses=statuses, warnings=tuple(said))
