"""Universal Mach-O files: the slices of two processors in one (Apple, <mach-o/fat.h>)."""

from __future__ import annotations

import struct

MAGIC = 0xCAFEBABE
ALIGNMENT = 14
"""Power of two on which slices start: pages of 16 KiB."""


def universal(*slices: bytes) -> bytes:
    """Return one universal file of thin 64-bit Mach-O files."""
    offset = 1 << ALIGNMENT
    header = struct.pack(">II", MAGIC, len(slices))
    body = bytearray()
    for piece in slices:
        _, processor, subtype = struct.unpack_from("<III", piece)
        header += struct.pack(">IIIII", processor, subtype, offset + len(body), len(piece), ALIGNMENT)
        body += piece
        body += bytes(-len(body) % (1 << ALIGNMENT))
    return header + bytes(offset - len(header)) + bytes(body)
