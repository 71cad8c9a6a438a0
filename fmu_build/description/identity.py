"""Identity of an FMU: its content in, GUID out."""

from __future__ import annotations

import hashlib
import uuid


def guid_of(*parts: bytes | str) -> str:
    """Return a GUID that is the same for the same content.

    Parameters
    ----------
    parts
        Content, as bytes or as text.

    Returns
    -------
    str
        The first 128 bits of the content's SHA-256 as a UUID of version 8 (RFC 9562, section 5.8), in braces.
    """
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        # The length before each part keeps ("ab", "c") and ("a", "bc") apart.
        digest.update(len(data).to_bytes(8, "little") + data)
    raw = bytearray(digest.digest()[:16])
    raw[6], raw[8] = raw[6] & 0x0F | 0x80, raw[8] & 0x3F | 0x80
    return f"{{{uuid.UUID(bytes=bytes(raw))}}}"
