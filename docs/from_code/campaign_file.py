"""Write the tables of ``docs/reference/campaign_file.md``: meanings from a list, what a key accepts from the code.

``python -m docs.from_code.campaign_file`` writes them, and the example from ``docs/examples/``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping

from docs.from_code.device_file import example
from docs.parts.tables import page_command, table, with_parts
from haptid.measurement.format import schema
from haptid.measurement.format.schema import Key
from haptid.model.joint.parameter_table import all_ids
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "reference" / "campaign_file.md"
LIST = ROOT / "docs" / "campaign_keys.toml"
KEYS: Mapping[str, Mapping[str, Key]] = {
    "CAMPAIGN": schema.CAMPAIGN,
    "SENSOR": schema.SENSOR,
    "JOINT": schema.JOINT,
    "PARAMETER": schema.PARAMETER,
    "DRIVE": schema.DRIVE,
    "CONTROLLER": schema.CONTROLLER,
    "RUN": schema.RUN,
    "FOREIGN_CAMPAIGN": schema.FOREIGN_CAMPAIGN,
    "INPUT": schema.INPUT,
    "OUTPUT": schema.OUTPUT,
    "FOREIGN_RUN": schema.FOREIGN_RUN,
}
HEADER = ("key", "meaning", "accepts", "unit", "default", "example")


def list_keys() -> dict[str, list[list[str]]]:
    """Return what is written of the keys of each table."""
    return tomllib.loads(LIST.read_text(encoding="utf-8"))


def keys_table(kind: str) -> str:
    """Return the keys of one table of ``campaign.toml``."""
    rows = []
    for key, meaning, unit, default, value in list_keys()[kind]:
        accepted = KEYS[kind][key].words
        rows.append((f"`{key}`", f"{meaning}.", accepted, unit, default, f"`{key} = {value}`"))
    return table(HEADER, rows)


def columns_table() -> str:
    """Return the columns of a run's table."""
    return table(("column", "meaning", "unit"), ((f"`{c}`", f"{m}.", u) for c, m, u in list_keys()["COLUMNS"]))


def with_tables(page: str) -> str:
    """Return the page with its generated parts made anew."""
    parts = {kind: keys_table(kind) for kind in KEYS}
    parts["COLUMNS"] = columns_table()
    parts["parameters"] = ", ".join(f"`{id}`" for id in all_ids())
    parts["example"] = example("campaign.toml", "toml")
    return with_parts(page, parts, "docs/from_code/campaign_file.py")


main = page_command(PAGE, with_tables)

if __name__ == "__main__":
    main()
