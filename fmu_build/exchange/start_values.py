"""Start values from a parameter set: `Identified` and an SSV file in, `Identified` for some equations out."""

from __future__ import annotations

from pathlib import Path

from haptid.fmu_build.description.provenance import Provenance
from haptid.fmu_build.description.units import parse_unit
from haptid.fmu_build.description.variables import structured_name
from haptid.fmu_build.exchange.identification_json import Identified
from haptid.fmu_build.exchange.possible import (
    Possible,
    check_value,
    of_joint_parameter,
    of_quantity,
    with_pairs_in_order,
)
from haptid.fmu_build.exchange.ssv_reader import Stated, read_ssv
from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.device.stated_parameters import ROWS
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean


def with_start_values(found: Identified, path: Path | None, equations: Equations) -> Identified:
    """Replace identified values by those of a parameter set.

    Parameters
    ----------
    found
        Identified values and provenance by id.
    path
        Parameter set in the format SSV; None to keep the identified values.
    equations
        Equations of the FMU, whose variable names the parameter set uses.

    Returns
    -------
    Identified
        Parameters, and states where the set states them; pairs as Fs ≥ Fc are in order to the last bit.

    Raises
    ------
    InputError
        Where the file is no parameter set (`fmu_build.exchange.ssv_reader.read_ssv`), or names a variable that the FMU
        does not have, another unit than the variable's, or an impossible value.
    """
    if path is None:
        values = with_pairs_in_order(found.values, equations, "values", of_fit=True)
        return Identified(values=values, provenance=found.provenance)
    ids = {structured_name(equations, q.id, q.structured): q.id for q in equations.parameters}
    ids |= {structured_name(equations, s.id, s.structured): s.id for s in equations.states}
    possible = {q.id: _possible(q) for q in equations.parameters}
    for s in equations.states:
        largest = THRESHOLDS.largest_magnitude_si
        possible[s.id] = Possible(least=-largest, most=largest, units=(s.unit,), description=s.description)
    values = dict(found.values)
    stated = read_ssv(path)
    if not stated:
        raise InputError(str(path), expected="values of parameters or states", got="none")
    for name, one in stated.items():
        where = f"{path}, line {one.line}"
        if name not in ids:
            todo = did_you_mean(name, ids)
            raise InputError(where, expected="parameters and states of this FMU", got=repr(name), todo=todo)
        _check_unit(one, possible[ids[name]].units[0], f"{where}: {name}")
        check_value(one.value, possible[ids[name]], f"{where}: {name}")
        values[ids[name]] = one.value
    source = Provenance(source=path.name, status="stated")
    provenance = {**found.provenance, **dict.fromkeys((ids[name] for name in stated), source)}
    return Identified(values=with_pairs_in_order(values, equations, str(path)), provenance=provenance)


def _possible(q: Quantity) -> Possible:
    """Return the possible values of a parameter in the equations' own unit; its id may end in a joint's number."""
    stem, _, tail = q.id.rpartition("_")
    name = stem if tail.isdigit() else q.id
    if name not in ROWS:
        return of_quantity(q)
    of_table = of_joint_parameter(name)
    return Possible(least=of_table.least, most=of_table.most, units=(q.unit,), description=of_table.description)


def _check_unit(stated: Stated, unit: str, where: str) -> None:
    if stated.unit is None:
        return
    wanted = parse_unit(unit)
    if (stated.unit.exponents, stated.unit.factor) != (wanted.exponents, wanted.factor):
        raise InputError(where, expected=f"the unit {unit}", got=repr(stated.unit.name))
