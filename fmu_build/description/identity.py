"""Identity of an FMU from its content."""

from __future__ import annotations

import hashlib
import uuid


def guid_of(*parts: bytes | str) -> str:
    """Return a GUID in braces, the same for the same content: a hash of it in the form of RFC 9562, version 8."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "little") + data)
    raw = bytearray(digest.digest()[:16])
    raw[6], raw[8] = raw[6] & 0x0F | 0x80, raw[8] & 0x3F | 0x80
    return f"{{{uuid.UUID(bytes=bytes(raw))}}}"
