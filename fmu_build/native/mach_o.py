"""Universal Mach-O files: binaries of several processors in, one file out (Apple, <mach-o/fat.h>)."""

from __future__ import annotations

import struct

MAGIC = 0xCAFEBABE
"""First four bytes of a universal file (``FAT_MAGIC``)."""
ALIGNMENT = 14
"""Exponent of two of the bytes on which slices start: pages of 16 KiB."""


def universal(*slices: bytes) -> bytes:
    """Join 64-bit Mach-O files of different processors.

    Parameters
    ----------
    slices
        Content of each file.

    Returns
    -------
    bytes
        A big-endian header with processor, offset, size and alignment of each slice, then the slices on page bounds.
    """
    offset = 1 << ALIGNMENT
    header = struct.pack(">II", MAGIC, len(slices))
    body = bytearray()
    for piece in slices:
        # A thin file is little-endian, as its processor; the header of a universal file is big-endian.
        _, processor, subtype = struct.unpack_from("<III", piece)
        header += struct.pack(">IIIII", processor, subtype, offset + len(body), len(piece), ALIGNMENT)
        body += piece
        body += bytes(-len(body) % (1 << ALIGNMENT))
    return header + bytes(offset - len(header)) + bytes(body)
