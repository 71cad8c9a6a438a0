r"""Display equations of the pages: fenced blocks ``math`` become pictures, so that no page needs a script or a network.

A block holds one equation in TeX, as far as Matplotlib's own typesetting goes, and its number as ``\tag{3}``.
Where the Markdown is read as it is, the TeX is what one reads; GitHub typesets it.
"""

from __future__ import annotations

import base64
import io
import re
from html import escape

import matplotlib as mpl
from matplotlib.font_manager import FontProperties
from matplotlib.mathtext import math_to_image

BLOCK = re.compile(r"^```math\n(?P<tex>.*?)\n```$", re.M | re.S)
TAG = re.compile(r"\s*\\tag\{(?P<number>[^}]*)\}")
# The picture's own units are points at 72 dpi; text of the pages has 16 px.
SETTINGS = {"mathtext.fontset": "stix", "svg.fonttype": "path", "svg.hashsalt": "equation", "savefig.facecolor": "none"}
SIZE_PT = 16.0


def svg_of(tex: str) -> str:
    """Return an equation as SVG; ``tex`` is one line without its number."""
    picture = io.BytesIO()
    with mpl.rc_context(SETTINGS):
        math_to_image(f"${tex}$", picture, prop=FontProperties(size=SIZE_PT), format="svg", dpi=72)
    text = picture.getvalue().decode()
    return re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.S)


def typeset(block: re.Match[str]) -> str:
    """Return the HTML of one fenced block."""
    source = " ".join(block["tex"].split())
    tag = TAG.search(source)
    tex = TAG.sub("", source)
    data = base64.b64encode(svg_of(tex).encode()).decode()
    number = f'<span class="number">({tag["number"]})</span>' if tag else ""
    picture = f'<img alt="{escape(tex)}" src="data:image/svg+xml;base64,{data}">'
    anchor = f' id="eq-{tag["number"]}"' if tag else ""
    return f'<div class="equation"{anchor}>{picture}{number}</div>'


def with_equations(page: str) -> str:
    """Return a page with its fenced blocks ``math`` typeset."""
    return BLOCK.sub(typeset, page)
