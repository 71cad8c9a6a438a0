"""``model.png`` of an FMU: time series in, PNG out, drawn without a plotting library."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT, MARGIN = 240, 160, 12
"""Size of the picture and distance of the axes from its edge [pixels]."""
OVERSAMPLING = 4
"""Points per pixel in each direction, averaged for smooth edges."""
PAPER, AXIS, LINE = (255, 255, 255), (206, 212, 218), (11, 114, 133)
"""Colours in RGB, 0 to 255."""


def picture(t: NDArray[np.float64], y: NDArray[np.float64]) -> bytes:
    """Draw a time series as a line over axes.

    Parameters
    ----------
    t, y
        Time and value, shape (n_t,) each; ``t`` ascends.

    Returns
    -------
    bytes
        PNG of 240 × 160 pixels without labels.
    """
    ink = np.zeros((HEIGHT * OVERSAMPLING, WIDTH * OVERSAMPLING))
    span = float(np.ptp(y)) or 1.0
    inner = np.array([WIDTH - 2 * MARGIN, HEIGHT - 2 * MARGIN])
    fine = np.linspace(t[0], t[-1], 20 * WIDTH * OVERSAMPLING)
    right = (fine - t[0]) / (t[-1] - t[0])
    up = 1.0 - (np.interp(fine, t, y) - y.min()) / span
    column, row = (
        np.rint((MARGIN + part * size) * OVERSAMPLING) for part, size in zip((right, up), inner, strict=True)
    )
    # A disc at every point of the finer image; the mean over its blocks gives smooth edges.
    half = OVERSAMPLING
    for dx in range(-half, half + 1):
        for dy in range(-half, half + 1):
            if dx * dx + dy * dy <= half * half:
                ink[row.astype(int) + dy, column.astype(int) + dx] = 1.0
    cover = ink.reshape(HEIGHT, OVERSAMPLING, WIDTH, OVERSAMPLING).mean(axis=(1, 3))[:, :, None]
    image = np.full((HEIGHT, WIDTH, 3), PAPER, dtype=float)
    image[MARGIN:-MARGIN, MARGIN] = AXIS
    image[-MARGIN, MARGIN:-MARGIN] = AXIS
    return _png(np.rint(image * (1 - cover) + np.array(LINE) * cover).astype(np.uint8))


def _png(image: NDArray[np.uint8]) -> bytes:
    """Encode 8-bit RGB (height, width, 3) (W3C, Portable Network Graphics, sections 11 and 12)."""
    height, width, _ = image.shape
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
