"""Write the tables of ``docs/theory/friction.md`` from the friction laws that are found: parameters and slots.

``python -m docs.from_code.friction`` writes them. What a law says in symbols, and from where it comes, stays prose.
"""

from __future__ import annotations

from docs.parts.tables import page_command, table, with_parts
from haptid.model.friction.registry import DEFAULT, laws
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "theory" / "friction.md"
ACTS_ON = {
    "friction_level": "the whole level of dry friction",
    "coulomb_level": "Fc and Fs",
    "kinetic_level": "Fc alone",
    "viscous_level": "σ2",
    "stribeck_velocity": "the speed that the Stribeck curve sees",
    "stribeck_argument": "the argument of the exponential in the Stribeck curve",
    "bristle": "formulas that read the deflection z",
}
"""What each slot of `haptid.model.friction.law` changes."""


def laws_table() -> str:
    """Return the laws with their names in files and their parameters."""
    rows = []
    for law in laws().values():
        name = f"`{law.id}`{' (default)' if law.id == DEFAULT else ''}"
        rows.append((law.title, name, ", ".join(f"`{id}`" for id in law.ids)))
    return table(("law", "in files", "parameters"), rows)


def slots_table() -> str:
    """Return which law has which slot."""
    rows = []
    for slot, words in ACTS_ON.items():
        having = ["yes" if slot in law.slots else "no" for law in laws().values()]
        rows.append((f"`{slot}`", words, *having))
    return table(("slot", "acts on", *(law.title for law in laws().values())), rows)


def with_tables(page: str) -> str:
    """Return the page with its generated parts made anew."""
    return with_parts(page, {"laws": laws_table(), "slots": slots_table()}, "docs/from_code/friction.py")


main = page_command(PAGE, with_tables)

if __name__ == "__main__":
    main()
