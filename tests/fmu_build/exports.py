"""The names that a shared library exports, read off its own tables."""

from __future__ import annotations

import shutil
import struct
import subprocess
from pathlib import Path

import pytest


def exported(path: Path) -> set[str]:
    """Of a Mach-O, PE (both 64-bit) or ELF file."""
    content = path.read_bytes()
    if path.suffix == ".dylib":
        return _mach_o(content)
    return _portable_executable(content) if path.suffix == ".dll" else _elf(path)


def _elf(path: Path) -> set[str]:
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("nm is not installed")
    listed = subprocess.run([nm, "-D", "--defined-only", path], capture_output=True, text=True, check=True).stdout
    return {line.split()[-1] for line in listed.splitlines()}


def _text(content: bytes, at: int) -> str:
    return content[at : content.index(b"\0", at)].decode()


def _mach_o(content: bytes) -> set[str]:
    """External defined symbols of LC_SYMTAB, without the leading underscore."""
    (commands,), at, names = struct.unpack_from("<I", content, 16), 32, set()
    for _ in range(commands):
        kind, size = struct.unpack_from("<II", content, at)
        if kind == 2:
            table, count, strings, _ = struct.unpack_from("<4I", content, at + 8)
            for entry in range(table, table + 16 * count, 16):
                name, flags, section = struct.unpack_from("<IBB", content, entry)
                if flags & 1 and section and not flags & 0x10:
                    names.add(_text(content, strings + name)[1:])
        at += size
    return names


def _portable_executable(content: bytes) -> set[str]:
    """Names of the export directory (the first data directory of the optional header)."""
    (header,) = struct.unpack_from("<I", content, 0x3C)
    sections, optional = struct.unpack_from("<H", content, header + 6)[0], header + 24
    first = optional + struct.unpack_from("<H", content, header + 20)[0]

    def place(address: int) -> int:
        for k in range(sections):
            size, start, _, raw = struct.unpack_from("<4I", content, first + 40 * k + 8)
            if start <= address < start + size:
                return raw + address - start
        raise LookupError(address)

    directory = place(struct.unpack_from("<I", content, optional + 112)[0])
    count, table = (
        struct.unpack_from("<I", content, directory + 24)[0],
        struct.unpack_from("<I", content, directory + 32)[0],
    )
    pointers = struct.unpack_from(f"<{count}I", content, place(table))
    return {_text(content, place(pointer)) for pointer in pointers}
