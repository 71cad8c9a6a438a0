"""A TOML file that can tell the line on which a key stands."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from haptid.support.errors import InputError
from haptid.support.files.data import parse_toml
from haptid.support.files.files import reason_of

HEADER = re.compile(r"^\s*\[{1,2}([^\[\]]+)\]{1,2}\s*(#.*)?$")


@dataclass(frozen=True, slots=True, kw_only=True)
class TomlSource:
    """Parsed data beside the text it came from."""

    path: Path
    text: str
    data: dict[str, Any]

    @classmethod
    def read(cls, path: Path) -> TomlSource:
        """Read and parse ``path``; a syntax error names its line."""
        try:
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(str(path), expected="a readable UTF-8 text file", got=reason_of(error)) from None
        return cls(path=path, text=text, data=parse_toml(text, str(path)))

    def line(self, section: str, key: str = "", occurrence: int = 0) -> int | None:
        """Line of ``key`` in the ``occurrence``-th table headed ``section`` (the header's own line without a key)."""
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
        """Name file, line (where it can be told) and key for an error message."""
        nth = occurrence or 0
        line = self.line(section, key, nth) or (self.line(section, "", nth) if section else self.line(key))
        name = section if occurrence is None else f"{section}[{occurrence}]"
        place = f"{self.path}, line {line}" if line else str(self.path)
        return f"{place}, {'.'.join(part for part in (name, key) if part)}"


def _assigns(content: str, key: str) -> bool:
    return re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*[=.]", content) is not None
