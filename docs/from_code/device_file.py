"""Write the tables of ``docs/reference/device_file.md`` from the schema of device files and the table of parameters.

``python -m docs.from_code.device_file`` writes them, and the two examples from ``docs/examples/``.
"""

from __future__ import annotations

import json
from typing import Any

from docs.parts.tables import page_command, table, with_parts
from haptid.model.device import ranges
from haptid.model.device.entries import OWN
from haptid.model.device.stated_parameters import ROWS
from haptid.model.friction.registry import laws
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "reference" / "device_file.md"
SCHEMA = ROOT / "model" / "device" / "device.schema.json"
EXAMPLES = ROOT / "docs" / "examples"
HEADER = ("key", "meaning", "unit", "default", "example")


def schema() -> dict[str, Any]:
    """Return the schema of device files."""
    found: dict[str, Any] = json.loads(SCHEMA.read_text(encoding="utf-8"))
    return found


def objects(tree: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the parts of the schema that describe a table of the file, by the name of the page's part."""
    top, kinds = tree["properties"], tree["$defs"]
    return {
        "top level": tree,
        "control_point": top["control_point"],
        "uncertainty": top["uncertainty"],
        "joints": kinds["joint"],
        "links": kinds["link"],
        "motors": kinds["motor"],
    }


def as_toml(value: Any) -> str:
    """Return a value as TOML writes it on one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        return "[" + ", ".join(map(as_toml, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {as_toml(entry)}" for key, entry in value.items()) + " }" if value else "{}"
    return f"{value:.4g}" if isinstance(value, float) and not value.is_integer() else str(value)


def default_of(key: str, rule: dict[str, Any], required: list[str]) -> str:
    """Return what holds where the key is left out."""
    if key in required:
        return "required"
    return f"`{as_toml(rule['default'])}`" if "default" in rule else "–"


def choices_of(rule: dict[str, Any]) -> str:
    """Return the words that a key may hold."""
    words = [f"`{word}`" for word in rule.get("enum", ())]
    return f" ({', '.join(words)})" if words else ""


def keys_table(part: dict[str, Any]) -> str:
    """Return the keys of one table of the file."""
    rows = []
    for key, rule in part["properties"].items():
        meaning = f"{rule['description']}{choices_of(rule)}."
        examples = rule.get("examples", ())
        example = f"`{key} = {as_toml(examples[0])}`" if examples else ""
        rows.append((f"`{key}`", meaning, rule.get("unit", ""), default_of(key, rule, part["required"]), example))
    return table(HEADER, rows)


def guess_table(tree: dict[str, Any]) -> str:
    """Return the keys of a first guess that is a table."""
    properties = [form.get("properties", {}) for form in tree["$defs"]["guess"]["oneOf"]]
    rows = [(f"`{key}`", f"{rule['description']}.") for each in properties for key, rule in each.items()]
    return table(("key", "meaning"), rows)


def parameters_table() -> str:
    """Return the parameters of a joint that a device file may guess, with what holds where it does not."""
    header = ("key", "of friction", "meaning", "unit", "unit, prismatic", "first guess", "bounds")
    rows = []
    for id in (*OWN, *dict.fromkeys(id for law in laws().values() for id in law.ids)):
        row, having = ROWS[id], [f"`{law.id}`" for law in laws().values() if id in law.ids]
        guess = f"{row.initial:g}{', fixed' if row.fixed else ''}"
        bounds = f"{row.lower:g} … {row.upper:g}"
        of = ", ".join(having) or "–"
        rows.append((f"`{row.id}`", of, row.description, row.unit, row.prismatic_unit, guess, bounds))
    return table(header, rows)


RANGES = (
    ("`gravity`", ranges.GRAVITY),
    ("`origin`, `centroid`, `control_point.position`", ranges.LENGTH),
    ("`rpy`", ranges.ANGLE),
    ("`position_limits`", ranges.POSITION),
    ("`torque_limit`", ranges.TORQUE),
    ("`max_frequency`", ranges.FREQUENCY),
    ("`mass`", ranges.MASS),
    ("`I11`, `I22`, `I33`", ranges.MOMENT),
    ("`I12`, `I13`, `I23`", ranges.PRODUCT),
    ("`motors.inertia`", ranges.ROTOR),
    ("`moved_by` of a link that turns", ranges.TURNS),
    ("`moved_by` of a prismatic link", ranges.TRAVEL),
    ("`motors.ratios`", ranges.GEAR),
    ("`uncertainty`, relative", ranges.RELATIVE),
    ("`uncertainty.centroid`", ranges.CENTROID_STD),
)


def ranges_table() -> str:
    """Return what the numbers of a device file may be."""
    rows = []
    for keys, one in RANGES:
        unit = "1" if one.unit.startswith(("(", "times")) else one.unit
        rows.append((keys, f"{one.least:g} … {one.most:g}{', or infinite' if one.infinite else ''}", unit))
    return table(("key", "range", "unit"), rows)


def example(name: str, language: str) -> str:
    """Return a file of ``docs/examples`` as a fenced block."""
    return f"```{language}\n{(EXAMPLES / name).read_text(encoding='utf-8')}```"


def with_tables(page: str) -> str:
    """Return the page with its generated parts made anew."""
    tree = schema()
    parts = {name: keys_table({"required": [], **part}) for name, part in objects(tree).items()}
    parts["guess"] = guess_table(tree)
    parts["parameters"] = parameters_table()
    parts["ranges"] = ranges_table()
    parts["example"] = example("two_joints.toml", "toml")
    parts["urdf example"] = example("two_joints.urdf", "xml")
    return with_parts(page, parts, "docs/from_code/device_file.py")


main = page_command(PAGE, with_tables)

if __name__ == "__main__":
    main()
