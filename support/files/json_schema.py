"""The check of a file's content against a JSON Schema, told in one line that names the key."""

from __future__ import annotations

import json
from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache
from importlib import resources
from typing import Any

import jsonschema
from jsonschema.exceptions import best_match

from haptid.support.errors import InputError

_WORDS = {
    "object": "a table { … }", "array": "a list [ … ]", "string": "a text", "number": "a number",
    "integer": "a whole number", "boolean": "true or false", "null": "null",
}  # fmt: skip


@cache
def _validator(package: str, name: str) -> jsonschema.Draft202012Validator:
    text = (resources.files(package) / name).read_text(encoding="utf-8")
    return jsonschema.Draft202012Validator(json.loads(text))


def check_content(data: Mapping[str, Any], where: str, wanted: str, schema: tuple[str, str]) -> None:
    """Refuse ``data`` where it does not follow the schema.

    Parameters
    ----------
    data
        The parsed content of a file.
    where
        The file, as errors name it.
    wanted
        What it should be, in words.
    schema
        Package and file name of the JSON Schema.

    Raises
    ------
    InputError
        Names the key at fault, what it should hold and what it holds.
    """
    errors = list(_validator(*schema).iter_errors(data))
    error = next((e for e in errors if list(e.absolute_path) == ["schema"]), best_match(errors))
    if error is not None:
        key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path).lstrip(".")
        at = f"{where}: {key}" if key else where
        raise InputError(at, expected=_expected(error, wanted), got=_got(error), todo=_todo(error))


def _rule_of(error: jsonschema.ValidationError) -> Any:
    """Return what the schema demands; the library's types leave open whether it is set."""
    return error.validator_value


def _missing(error: jsonschema.ValidationError) -> str:
    return next(name for name in _rule_of(error) if name not in _instance(error))


def _instance(error: jsonschema.ValidationError) -> Any:
    """Return the content at fault."""
    return error.instance


def _expected(error: jsonschema.ValidationError, wanted: str) -> str:
    rule, value = str(error.validator), _rule_of(error)
    if rule == "required":
        return f"the key {_missing(error)!r}" if error.absolute_path else f"{wanted} with the key {_missing(error)!r}"
    if rule == "type":
        return " or ".join(_WORDS[name] for name in ([value] if isinstance(value, str) else value))
    if rule == "const":
        return f"{wanted} of schema {value!r}"
    if rule == "enum":
        return "one of " + ", ".join(map(str, value))
    return _BOUNDS.get(rule, f"{rule} {{}}").format(value)


_BOUNDS = {
    "minimum": "a number of {} or more", "maximum": "a number of {} or less",
    "minItems": "{} entries or more", "minLength": "{} characters or more",
    "pattern": "a text as {}", "uniqueItems": "every entry once",
}  # fmt: skip


def _got(error: jsonschema.ValidationError) -> str:
    value = _instance(error)
    if error.validator == "required":
        return ", ".join(map(repr, value)) or "an empty table"
    if isinstance(value, dict | list):
        return f"{_WORDS['object' if isinstance(value, dict) else 'array']} with {len(value)} entries"
    return repr(value)


def _todo(error: jsonschema.ValidationError) -> str:
    if error.validator != "required":
        return ""
    near = get_close_matches(_missing(error), list(_instance(error)), n=1)
    return f"is {near[0]!r} a misspelling of it?" if near else ""
