r"""Display equations of the pages: fenced blocks ``math`` become MathML, so that no page needs a script or a network.

A block holds one equation in TeX, and its number as ``\tag{3}``. Where the Markdown is read as it is, the TeX is what
one reads; GitHub typesets it. Browsers typeset the MathML, screen readers read it.
"""

from __future__ import annotations

import re
from html import escape

from latex2mathml.converter import convert

BLOCK = re.compile(r"^```math\n(?P<tex>.*?)\n```$", re.M | re.S)
TAG = re.compile(r"\s*\\tag\{(?P<number>[^}]*)\}")
COMMAND = re.compile(r"\\[a-zA-Z]+")
FUNCTION = re.compile(r"(<mi>[a-z]{2,}</mi>)(?!<mo stretchy=\"false\">&#x00028;)")
"""A function's name whose argument stands without brackets."""


def mathml_of(tex: str) -> str:
    """Return an equation as MathML.

    Parameters
    ----------
    tex
        One line without its number.

    Returns
    -------
    str
        Element ``math`` with the TeX as its label.

    Raises
    ------
    ValueError
        Where a command of the TeX is not understood: it would stand in the page as it is.
    """
    mathml = convert(tex, display="block")
    unknown = COMMAND.findall(mathml)
    if unknown:
        msg = f"equation {tex!r}: {unknown[0]} is not understood"
        raise ValueError(msg)
    spaced = FUNCTION.sub(r'\1<mspace width="0.167em" />', mathml)  # the library sets sin and its argument together
    return spaced.replace("<math ", f'<math aria-label="{escape(tex)}" ', 1)


def typeset(block: re.Match[str]) -> str:
    """Return the HTML of one fenced block."""
    source = " ".join(block["tex"].split())
    tag = TAG.search(source)
    mathml = mathml_of(TAG.sub("", source))
    number = f'<span class="number">({tag["number"]})</span>' if tag else ""
    anchor = f' id="eq-{tag["number"]}"' if tag else ""
    return f'<div class="equation"{anchor} markdown="0">{mathml}{number}</div>'


def with_equations(page: str) -> str:
    """Return a page with its fenced blocks ``math`` typeset."""
    return BLOCK.sub(typeset, page)
