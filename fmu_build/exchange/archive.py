"""Reproducible zip archives: files in, the same bytes for the same files out (entries sorted, date and mode fixed)."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Mapping

EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest date that a zip archive can hold."""
_FIRST = "modelDescription.xml"


def pack(files: Mapping[str, bytes]) -> bytes:
    """Pack files into a zip archive.

    Parameters
    ----------
    files
        Content by name within the archive, in any order.

    Returns
    -------
    bytes
        Deflated archive with the model description first, the others by name.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=zlib.Z_BEST_COMPRESSION) as archive:
        for name in sorted(files, key=lambda name: (name != _FIRST, name)):
            entry = zipfile.ZipInfo(name, date_time=EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix on every machine, as the mode below supposes
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])
    return stream.getvalue()


def unpack(data: bytes) -> dict[str, bytes]:
    """Return the content of every file in a zip archive by its name; folders are left out.

    Parameters
    ----------
    data
        Zip archive.

    Returns
    -------
    dict of str to bytes
        Content by name.

    Raises
    ------
    zipfile.BadZipFile
        Where the data are no zip archive.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {entry.filename: archive.read(entry) for entry in archive.infolist() if not entry.is_dir()}
