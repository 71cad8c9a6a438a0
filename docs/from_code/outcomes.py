"""Write ``docs/reference/outcomes.md``: every word in which a result judges, what it means, and what to do.

``python -m docs.from_code.outcomes`` writes the tables from `haptid.report.common.words`, which the pages use as well.
"""

from __future__ import annotations

from docs.parts.tables import page_command, table, with_parts
from haptid.report.common.words import GROUPS, Word
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "reference" / "outcomes.md"
SIGNS = {"good": "✓", "look": "!", "bad": "✕", "plain": ""}
"""Sign before a word on a page by its level."""


def words_table() -> str:
    """Return all words, group by group."""
    header = ("word", "sign", "means", "what to do")
    return "\n".join(f"## {title}\n\n{table(header, map(_row, words))}" for title, words in GROUPS.items())


def _row(word: Word) -> tuple[str, ...]:
    return f"`{word.key.partition('-')[2]}`", SIGNS[word.level], word.meaning, word.action


def with_tables(page: str) -> str:
    """Return the page with its generated part made anew."""
    return with_parts(page, {"words": words_table()}, "docs/from_code/outcomes.py")


main = page_command(PAGE, with_tables)

if __name__ == "__main__":
    main()
