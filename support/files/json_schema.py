"""Validation of a file's content by a JSON Schema: values in, an `InputError` of one line that names the key out."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from importlib import resources
from typing import Any

import jsonschema
from jsonschema.exceptions import best_match

from haptid.support.errors import InputError
from haptid.support.files.place import Place
from haptid.support.suggestion import did_you_mean

_WORDS = {
    "object": "a table { … }", "array": "a list [ … ]", "string": "a text", "number": "a number",
    "integer": "a whole number", "boolean": "true or false", "null": "null",
}  # fmt: skip


@cache
def _validator(package: str, name: str) -> jsonschema.Draft202012Validator:
    text = (resources.files(package) / name).read_text(encoding="utf-8")
    return jsonschema.Draft202012Validator(json.loads(text))


def check_content(data: Mapping[str, Any], where: str | Place, wanted: str, schema: tuple[str, str]) -> None:
    """Refuse ``data`` where it does not follow the schema.

    Parameters
    ----------
    data
        The parsed content of a file.
    where
        Name or place of the file in errors.
    wanted
        Kind of file that is expected, in words.
    schema
        Package and file name of the JSON Schema. Where a rule is hard to read (``pattern``, ``oneOf``), the
        ``expected`` beside it says in words what is expected.

    Raises
    ------
    InputError
        Names the key at fault, what it should hold and what it holds.
    """
    errors = list(_validator(*schema).iter_errors(data))
    # A file of another kind or version violates many rules: the key ``schema`` says so, before all of them.
    error = next((e for e in errors if list(e.absolute_path) == ["schema"]), best_match(errors))
    if error is not None:
        place = where if isinstance(where, Place) else Place(file=where)
        place = place.at(*error.absolute_path, *_unknown(error)[:1])
        raise InputError(str(place), expected=_describe_expected(error, wanted), got=_got(error), todo=_todo(error))


def _rule_of(error: jsonschema.ValidationError) -> Any:
    """Return what the schema demands; the library's types leave open whether it is set."""
    return error.validator_value


def _missing(error: jsonschema.ValidationError) -> str:
    return next(name for name in _list_demanded_keys(error) if name not in _instance(error))


def _list_demanded_keys(error: jsonschema.ValidationError) -> Iterator[str]:
    rule = _rule_of(error)
    if error.validator == "required":
        yield from rule
        return
    for name, others in rule.items():  # dependentRequired
        if name in _instance(error):
            yield from others


def _unknown(error: jsonschema.ValidationError) -> list[str]:
    """Return the keys that a table must not have."""
    if error.validator != "additionalProperties":
        return []
    patterns = _schema(error).get("patternProperties", {})
    known = _schema(error).get("properties", {})
    return [k for k in _instance(error) if k not in known and not any(re.search(p, k) for p in patterns)]


def _schema(error: jsonschema.ValidationError) -> Any:
    """Return the part of the schema that holds the rule."""
    return error.schema


def _instance(error: jsonschema.ValidationError) -> Any:
    """Return the content at fault."""
    return error.instance


def _describe_expected(error: jsonschema.ValidationError, wanted: str) -> str:
    rule, value, words = str(error.validator), _rule_of(error), _expected_words(error)
    if words:
        return words
    if rule in ("required", "dependentRequired"):
        return f"the key {_missing(error)!r}" if error.absolute_path else f"{wanted} with the key {_missing(error)!r}"
    if rule == "type":
        return " or ".join(_WORDS[name] for name in ([value] if isinstance(value, str) else value))
    if rule == "const":
        return f"{wanted} of schema {value!r}"
    if rule == "enum":
        return "one of " + ", ".join(map(str, value))
    return _BOUNDS.get(rule, f"{rule} {{}}").format(value)


def _expected_words(error: Any) -> str:
    """Return the words that the schema has for a rule that is hard to read, or for a choice of several forms."""
    if error.parent is not None and error.validator in ("type", "required"):
        return _expected_words(error.parent)
    hard = error.validator in ("pattern", "oneOf", "anyOf")
    hard |= error.validator == "additionalProperties" and not _schema(error).get("properties")
    return str(_schema(error).get("expected", "")) if hard else ""


_BOUNDS = {
    "minimum": "a number of {} or more", "maximum": "a number of {} or less",
    "minItems": "{} entries or more", "minLength": "{} characters or more",
    "pattern": "a text as {}", "uniqueItems": "every entry once", "maxItems": "{} entries or fewer",
    "exclusiveMinimum": "a number above {}", "minProperties": "{} entries or more",
    "additionalProperties": "a known key",
}  # fmt: skip


def _got(error: jsonschema.ValidationError) -> str:
    value = _instance(error)
    if error.validator in ("required", "dependentRequired"):
        return ", ".join(map(repr, value)) or "an empty table"
    if error.validator == "additionalProperties":
        return ", ".join(map(repr, _unknown(error)))
    if isinstance(value, dict) and error.validator == "oneOf":
        return f"{{ {', '.join(map(str, value))} }}"
    if isinstance(value, dict | list):
        return f"{_WORDS['object' if isinstance(value, dict) else 'array']} with {len(value)} entries"
    return repr(value)


def _todo(error: jsonschema.ValidationError) -> str:
    if error.validator == "additionalProperties":
        known = list(_schema(error).get("properties", ()))
        return did_you_mean(_unknown(error)[0], known) if known else ""
    # A table that fits none of several forms: a key that no form knows is the likeliest fault.
    if error.validator == "oneOf" and isinstance(_instance(error), dict):
        known = [name for form in _rule_of(error) for name in form.get("properties", ())]
        return next((did_you_mean(name, known) for name in _instance(error) if name not in known), "keep one form")
    if error.validator == "enum" and isinstance(_instance(error), str):
        near = get_close_matches(_instance(error)[:80], list(map(str, _rule_of(error))), n=1)
        return f"did you mean {near[0]}?" if near else ""
    if error.validator != "required":
        return ""
    # A missing key is often there under a misspelt name.
    near = get_close_matches(_missing(error), list(_instance(error)), n=1)
    return f"is {near[0]!r} a misspelling of it?" if near else ""
