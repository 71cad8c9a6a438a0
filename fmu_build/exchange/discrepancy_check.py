"""Check the parameters that a ``discrepancy/joint<j>.json`` states: its content in, nothing out or an `InputError`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from haptid.fmu_build.exchange.identification_check import COEFFICIENT
from haptid.fmu_build.exchange.possible import check_entry, check_order, check_value, of_joint_parameter, of_quantity
from haptid.model.device.stated_parameters import ORDERED, ROWS
from haptid.model.effects.effect import Effect
from haptid.model.equations.joint_parameters import sliding
from haptid.model.joint.joint_in_device import of_the_test_alone
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean


def check_refit(refit: Mapping[str, float], effects: Sequence[Effect], where: str) -> None:
    """Check the values of a refit.

    Parameters
    ----------
    refit
        Value by id of the parameter of the joint alone, SI units; empty where the search refitted nothing.
    effects
        Catalogue effects that the search named.
    where
        File and key, for errors.

    Raises
    ------
    InputError
        Where neither the joint nor an effect has the parameter, its value is impossible, Fs lies below Fc, or an
        effect that goes into the whole device lacks a value.
    """
    own = {q.id: q for e in effects for q in e.parameters}
    for id, value in refit.items():
        if id in ROWS:
            check_value(value, of_joint_parameter(id), f"{where}.{id}")
        elif id in own:
            check_value(value, of_quantity(own[id]), f"{where}.{id}")
        elif not COEFFICIENT.fullmatch(id):
            expected, todo = "parameters of the joint and its effects", did_you_mean(id, [*ROWS, *own])
            raise InputError(where, expected=expected, got=repr(id), todo=todo)
    for larger, smaller in ORDERED:
        check_order(larger, smaller, refit, {}, where)
    if refit:
        _check_complete(refit, effects, where)


def _check_complete(refit: Mapping[str, float], effects: Sequence[Effect], where: str) -> None:
    for effect in effects:
        for id in _list_needed_parameters(effect):
            if id not in refit:
                todo = f"{effect.id} has no value without it"
                raise InputError(where, expected=f"the key {id!r}", got=", ".join(refit), todo=todo)


def _list_needed_parameters(effect: Effect) -> list[str]:
    """Return the parameters of an effect that a refit must state.

    None for an effect that the whole device does not include; else all that are fitted or scaled to the test.
    """
    if of_the_test_alone(effect):
        return []
    return [q.id for q in effect.parameters if q.id in {*effect.relative, *effect.origin} or not q.fixed]


def check_estimates(estimates: Mapping[str, Any], effect: Effect, where: str) -> None:
    """Check the estimates of one effect.

    Parameters
    ----------
    estimates
        Entry ``{value, unit, lower, upper}`` by id of the parameter.
    effect
        Catalogue effect that they belong to.
    where
        File and key, for errors.

    Raises
    ------
    InputError
        Where the effect has no such parameter, or its value, bounds or unit are impossible.
    """
    own = {q.id: q for q in effect.parameters}
    for id, entry in estimates.items():
        if id not in own:
            expected, todo = f"parameters of {effect.id}", did_you_mean(id, own)
            raise InputError(where, expected=expected, got=repr(id), todo=todo)
        possible = of_quantity(own[id])
        check_entry(entry, replace(possible, units=(own[id].unit, sliding(own[id].unit))), f"{where}.{id}")
