"""`TomlSource`: a parsed TOML file beside its text, for errors that name the line of a key.

The parser of the standard library returns no line numbers, so headings and keys are searched for in the text.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from haptid.support.errors import InputError
from haptid.support.files.data import parse_toml
from haptid.support.files.files import reason_of

HEADER = re.compile(r"^\s*\[{1,2}([^\[\]]+)\]{1,2}\s*(#.*)?$")
"""Line with the heading of a table or of an entry of an array of tables."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TomlSource:
    """Hold a TOML file as text and as parsed data.

    Parameters
    ----------
    path
        The file.
    text
        Its content.
    data
        The content as nested dictionaries and lists.
    """

    path: Path
    text: str
    data: dict[str, Any]

    @classmethod
    def parse(cls, path: Path) -> TomlSource:
        """Read and parse a TOML file, UTF-8 with or without byte order mark.

        Parameters
        ----------
        path
            The file.

        Returns
        -------
        TomlSource
            Its text and content.

        Raises
        ------
        InputError
            Where the file cannot be read, or is no TOML; a syntax error names its line.
        """
        try:
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(str(path), expected="a readable UTF-8 text file", got=reason_of(error)) from None
        return cls(path=path, text=text, data=parse_toml(text, str(path)))

    def line(self, section: str, key: str = "", occurrence: int = 0) -> int | None:
        """Return the line on which a key or a table heading stands.

        Parameters
        ----------
        section
            Heading of the table without brackets; "" for the keys before the first heading.
        key
            Key in that table; "" for the heading itself.
        occurrence
            Number of the table among those with this heading, from 0.

        Returns
        -------
        int or None
            From 1; None where the text does not show it, as for keys in inline tables. A heading of which only
            subtables stand in the text has the line of the first of them.
        """
        current, seen = "", 0
        for number, content in enumerate(self.text.splitlines(), start=1):
            header = HEADER.match(content)
            if header:
                current = re.sub(r"[\s\"']", "", header.group(1))
                seen += current == section
                below = occurrence == 0 and current.startswith(f"{section}.")
                if not key and (below or (current == section and seen == occurrence + 1)):
                    return number
            elif key and current == section and (not section or seen == occurrence + 1) and _assigns(content, key):
                return number
        return None

    def where(self, section: str, key: str = "", occurrence: int | None = None) -> str:
        """Name file, line and key for an error message; a key without a line has its table's heading's line.

        Parameters
        ----------
        section, key
            As for `line`.
        occurrence
            Number of the table in an array of tables, from 0; None for a table that is in no array.

        Returns
        -------
        str
            As ``campaign.toml, line 12, runs[0].file``.
        """
        nth = occurrence or 0
        line = self.line(section, key, nth) or (self.line(section, "", nth) if section else self.line(key))
        name = section if occurrence is None else f"{section}[{occurrence}]"
        place = f"{self.path}, line {line}" if line else str(self.path)
        return f"{place}, {'.'.join(part for part in (name, key) if part)}"


def _assigns(content: str, key: str) -> bool:
    return re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*[=.]", content) is not None
