"""Keys of ``campaign.toml`` as data (one `Key` each), and the check of one TOML table against them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeGuard

from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.thresholds import THRESHOLDS
from haptid.model.friction.registry import laws
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Key:
    """Say which values a key of a TOML table may hold.

    Parameters
    ----------
    accepts
        Whether a value is one of them.
    words
        The same in words, for the error.
    required
        Whether the table must have the key.
    """

    accepts: Callable[[object], bool]
    words: str
    required: bool = False


def is_number(value: object) -> TypeGuard[float]:
    """Return whether ``value`` is a finite number; true and false, which Python counts as integers, are none.

    Parameters
    ----------
    value
        Value of a TOML or JSON file.

    Returns
    -------
    bool
        False for NaN, infinity and every other type.
    """
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _is_flag(value: object) -> bool:
    return isinstance(value, bool)


def _is_joints(value: object) -> bool:
    if not isinstance(value, list) or not all(isinstance(j, int) and not isinstance(j, bool) for j in value):
        return False
    return len(value) > 0 and len(set(value)) == len(value) and min(value) >= 0


def _is_numbers(value: object) -> bool:
    return isinstance(value, list) and all(is_number(entry) for entry in value)


def _one_of(*choices: str) -> Callable[[object], bool]:
    return lambda value: isinstance(value, str) and value in choices


def _is_prior(value: object) -> bool:
    if not isinstance(value, dict) or set(value) != {"mean", "std"} or not all(is_number(v) for v in value.values()):
        return False
    return bool(value["std"] > 0)


def _is_positive(value: object) -> bool:
    return is_number(value) and value > 0


def _is_start(value: object) -> bool:
    return isinstance(value, dict) and all(is_number(entry) or isinstance(entry, bool) for entry in value.values())


def _is_noise(value: object) -> bool:
    return is_number(value) and THRESHOLDS.smallest_noise_or_step <= value <= THRESHOLDS.largest_noise_or_step


def _is_step(value: object) -> bool:
    return is_number(value) and (
        value == 0 or THRESHOLDS.smallest_noise_or_step <= value <= THRESHOLDS.largest_noise_or_step
    )


def _is_window(value: object) -> bool:
    whole = isinstance(value, int) and not isinstance(value, bool)
    return whole and 1 <= value <= THRESHOLDS.most_averaged_rows and value % 2 == 1  # type: ignore[operator] # a number


def _is_constant(value: object) -> bool:
    return (
        is_number(value) and THRESHOLDS.smallest_torque_per_ampere <= abs(value) <= THRESHOLDS.largest_torque_per_ampere
    )


def _is_posture(value: object) -> bool:
    return _is_numbers(value) and all(abs(entry) <= THRESHOLDS.largest_locked_position for entry in value)  # type: ignore[attr-defined] # a list


TEXT = Key(accepts=_is_text, words="a text in quotes")
NUMBER = Key(accepts=is_number, words="a finite number")
HOLD = Key(accepts=_one_of("zero", "linear"), words='"zero" or "linear"')
SIZES = f"{THRESHOLDS.smallest_noise_or_step:g} to {THRESHOLDS.largest_noise_or_step:g}"
NOISE = Key(accepts=_is_noise, words=f"a positive number (standard deviation of the white noise, {SIZES})")
STEP = Key(accepts=_is_step, words=f"0, or a positive number (encoder step, {SIZES})")
CONSTANT = Key(
    accepts=_is_constant,
    words=f"a number of size {THRESHOLDS.smallest_torque_per_ampere:g} to {THRESHOLDS.largest_torque_per_ampere:g}",
)

NUMBER_OR_ENTRY = Key(
    accepts=lambda value: _is_positive(value) or isinstance(value, dict),
    words="a positive number, or { initial, lower, upper, prior, fixed }",
)
GAIN = Key(accepts=_is_positive, words="a positive number", required=True)
LEAST_ZERO = Key(accepts=lambda value: is_number(value) and value >= 0, words="a number of at least 0")

REMARKED = dict.fromkeys(("note", "date", "author", "licence"), Key(accepts=lambda _: True, words="anything"))
CAMPAIGN = {
    "title": TEXT,
    "device": Key(accepts=_is_text, words='a device name or file, as in "single_joint"', required=True),
    "measured": Key(accepts=_is_flag, words="true (measured) or false (synthetic)", required=True),
    "hold": HOLD,
    **REMARKED,
}
WINDOW = Key(accepts=_is_window, words=f"an odd number of rows, 1 to {THRESHOLDS.most_averaged_rows}")
OWN_SENSOR = {"noise_rad": NOISE, "resolution_rad": STEP, "noise_m": NOISE, "resolution_m": STEP}
SENSOR = {**OWN_SENSOR, "averaged_rows": WINDOW}
RUN = {
    "file": Key(accepts=_is_text, words='the name of a table, as in "joint4.csv"', required=True),
    "free_joints": Key(accepts=_is_joints, words="distinct joint numbers, as in [4] or [0, 1]", required=True),
    "locked_positions_rad": Key(
        accepts=_is_posture,
        words=f"a list with one number per joint, none beyond {THRESHOLDS.largest_locked_position:g}",
    ),
    "use": Key(accepts=_one_of("fit", "validate", "excluded"), words='"fit", "validate" or "excluded"', required=True),
    "reason": TEXT,
    "hold": HOLD,
    "controller_gain": Key(accepts=_is_positive, words="a positive number"),
    "note": TEXT,
}
JOINT = {
    "friction": Key(
        accepts=lambda value: isinstance(value, str) and value in laws(), words=f"a friction law ({', '.join(laws())})"
    ),
    "parameters": Key(accepts=lambda value: isinstance(value, dict), words="a table of parameters"),
    "sensor": Key(accepts=lambda value: isinstance(value, dict), words="a table with noise_rad, resolution_rad"),
    "drive": Key(accepts=lambda value: isinstance(value, dict), words="a table with kind"),
    "controller": Key(
        accepts=lambda value: isinstance(value, dict),
        words="a table with kind, gain and limit, in the drive's unit (N m without a drive)",
    ),
    "torque_constant_Nm_per_A": CONSTANT,
    "force_constant_N_per_A": CONSTANT,
}
DRIVE = {
    "kind": Key(
        accepts=_one_of("torque", "current", "voltage", "duty"),
        words='"torque", "current", "voltage" or "duty"',
        required=True,
    ),
    "torque_constant": NUMBER_OR_ENTRY,
    "resistance_ohm": NUMBER_OR_ENTRY,
}
CONTROLLER = {
    "kind": Key(accepts=_one_of("p", "pd", "pid"), words='"p", "pd" or "pid"', required=True),
    "gain": GAIN,
    "limit": GAIN,
    "derivative_gain": LEAST_ZERO,
    "integral_gain": LEAST_ZERO,
}
PARAMETER = {
    "initial": NUMBER,
    "lower": NUMBER,
    "upper": NUMBER,
    "fixed": NUMBER,
    "prior": Key(accepts=_is_prior, words="{ mean = number, std = positive number }"),
}

FOREIGN_CAMPAIGN = {
    "title": TEXT,
    "model": Key(accepts=_is_text, words='the file of an FMU, as in "oscillator.fmu"'),
    "measured": CAMPAIGN["measured"],
    "hold": HOLD,
    **REMARKED,
}
COLUMN = Key(accepts=_is_text, words='the name of a column, as in "force_N"', required=True)
INPUT = {"column": COLUMN}
OUTPUT = {
    "column": COLUMN,
    "noise": Key(accepts=_is_positive, words="a positive number (standard deviation of the noise, the output's unit)"),
}
FOREIGN_RUN = {
    **{key: RUN[key] for key in ("file", "use", "reason", "note")},
    "start": Key(accepts=_is_start, words="a table of numbers by variable, as in { x = 2.0 }"),
}


def check_table(
    source: TomlSource, table: object, keys: Mapping[str, Key], section: str, occurrence: int | None = None
) -> dict[str, Any]:
    """Check that a table holds only known keys of the right kind and all required ones.

    Parameters
    ----------
    source
        The parsed file, for the line that an error names.
    table
        What stands under the heading; None where there is none.
    keys
        Known keys by name.
    section
        Heading of the table, as ``joint.4.sensor``.
    occurrence
        Number of the table among those with this heading, from 0; None for a heading that occurs once.

    Returns
    -------
    dict
        The table itself.

    Raises
    ------
    InputError
        At the first key at fault.
    """
    if not isinstance(table, dict):
        raise InputError(source.where("", section), expected=f"a table [{section}]", got=repr(table))
    for name, value in table.items():
        if name not in keys:
            where, todo = source.where(section, name, occurrence), did_you_mean(name, keys)
            raise InputError(where, expected="a known key", got=repr(name), todo=todo)
        if not keys[name].accepts(value):
            raise InputError(source.where(section, name, occurrence), expected=keys[name].words, got=repr(value))
    for name, key in keys.items():
        if key.required and name not in table:
            raise InputError(source.where(section, name, occurrence), expected=key.words, got="no such key")
    return table


def check_parameter(source: TomlSource, entry: Mapping[str, Any], section: str, name: str) -> None:
    """Refuse unknown keys of one parameter, and keys that hold something else than a number or a prior.

    Parameters
    ----------
    source
        The parsed file, for the line that an error names.
    entry
        Entry of the parameter, as ``{ initial = 1.0, lower = 0.5 }``.
    section
        Heading of the table, as ``joint.4.parameters``.
    name
        Name of the parameter.

    Raises
    ------
    InputError
        At the first key at fault.
    """
    for key, value in entry.items():
        place = f"{source.where(section, name)}.{key}"
        if key not in PARAMETER:
            raise InputError(place, expected="a known key", got=repr(key), todo=did_you_mean(key, PARAMETER))
        if not PARAMETER[key].accepts(value):
            raise InputError(place, expected=PARAMETER[key].words, got=repr(value))
