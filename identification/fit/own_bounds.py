"""Bounds that haptid chose: a fit that ends on one of them is repeated with a wider range.

The range of a parameter that neither user nor device states is a guess. An optimum on its end is a statement about the
guess, not about the joint, so that nothing is said before the range is wider:

1. Find the parameters at an end of their range that nobody stated and that physics does not set (`wider_ranges`).
2. Widen these ranges and fit again, from the optimum alone where it is one of a free simulation.
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
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.registry import law_named

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
    alone = False
    open_ends: tuple[str, ...] = ()
    for _ in range(THRESHOLDS.most_widenings_of_bounds):
        wider = wider_ranges(found, own)
        if not wider:
            break
        ranged = equations.with_parameters(wider)
        # From a minimum of the last gain one start takes a tenth of the time of all of them, and lowers the cost
        # wherever the range alone held it.
        by_one_start = found.observer_gain == options.gains[-1]
        again = fit_equations(ranged, from_optimum(found, options, alone=by_one_start))
        if not _better(again, found, runs):
            open_ends = tuple(wider)
            break
        found, equations, alone = again, ranged, by_one_start
    if alone and (quiet(found, options) or (needs_finer_step is not None and needs_finer_step(found))):
        found = with_agreement(found, first, options)
    elif alone and (options.starts > 1 or len(options.gains) > 1):  # else it would be the same fit once more
        everywhere = fit_equations(equations, from_optimum(found, options))
        found = found if _better(found, everywhere, runs) else everywhere
    return _tell_open_ends(found, open_ends) if open_ends else found


def wider_ranges(found: Fit, own: Sequence[str]) -> dict[str, dict[str, object]]:
    """Widen the ranges at whose ends the estimates lie.

    Parameters
    ----------
    found
        Fit whose equations hold the ranges.
    own
        Ids of the parameters whose range haptid chose.

    Returns
    -------
    dict
        First guess (the estimate), ``lower`` and ``upper`` by id. An end at 0 of a quantity that cannot be negative
        stays, and so does the range of a spring's equilibrium where there is no spring.
    """
    parametrisation = Parametrisation.of(found.equations)
    s = parametrisation.to_coordinates(found.theta)
    result: dict[str, dict[str, object]] = {}
    for quantity, edge in zip(parametrisation.quantities, on_bound(parametrisation, s), strict=True):
        value = found.values[quantity.id]
        if edge and quantity.id in own and not _is_of_absent_spring(quantity.id, found):
            lower, upper = _widen_range(quantity, value)
            if (lower, upper) != (quantity.lower, quantity.upper):
                result[quantity.id] = {"initial": value, "lower": lower, "upper": upper}
    return result


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
        value = f"{id} = {found.values[id]:.3g} {quantity.unit}"
        if id.split("_")[0] in stiff and found.values[id] > quantity.initial:
            said.append(f"presliding is too stiff to be seen: from {value} on, a stiffer one gives the same motion")
        else:
            said.append(f"{value} is the end of its range, and a wider range fits no better: the runs leave it open")
    statuses = {id: "unidentifiable" if id in ids else status for id, status in found.statuses.items()}
    return found.but(statuses=statuses, warnings=(*found.warnings, *said))
