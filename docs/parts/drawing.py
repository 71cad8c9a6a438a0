"""Boxes and arrows as SVG, on a ground of its own, so that a figure reads on light and on dark pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

Point = tuple[float, float]

STYLE = """<style>
 text { font-family: Helvetica, Arial, sans-serif; fill: #1c2733; }
 .ground { fill: #fbfbf8; stroke: #b8bfc6; }
 .package { fill: #e3ecf7; stroke: #33608c; stroke-width: 1.5; }
 .file { fill: #ffffff; stroke: #6d7781; stroke-dasharray: 4 3; }
 .choice { fill: #fdf1d8; stroke: #a9762a; stroke-width: 1.5; }
 .end { fill: #e4f1e4; stroke: #3c7a45; stroke-width: 1.5; }
 .title { font-size: 15px; font-weight: bold; }
 .small { font-size: 12px; }
 .label { font-size: 12px; font-style: italic; }
 .arrow { fill: none; stroke: #1c2733; stroke-width: 1.4; marker-end: url(#tip); }
</style>
<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto">
<path d="M0,0 L10,5 L0,10 z" fill="#1c2733"/></marker></defs>
"""
LINE_HEIGHT = 16.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A box with a title and lines below it; ``kind`` is one of the classes of `STYLE`."""

    at: Point
    size: Point
    title: str
    lines: tuple[str, ...] = ()
    kind: str = "package"

    def svg(self) -> str:
        """Return the box, its text in the middle."""
        (x, y), (width, height) = self.at, self.size
        corner = 0 if self.kind == "file" else 7
        drawn = f'<rect class="{self.kind}" x="{x}" y="{y}" width="{width}" height="{height}" rx="{corner}"/>\n'
        middle = y + height / 2 + 5 - LINE_HEIGHT * len(self.lines) / 2
        texts = [(self.title, "title"), *((line, "small") for line in self.lines)]
        for number, (text, style) in enumerate(texts):
            drawn += write_line(text, (x + width / 2, middle + LINE_HEIGHT * number), style, "middle")
        return drawn


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrow:
    """A line through points with a tip at its end; ``anchor`` says whether its label is centred at ``label_at``."""

    through: Sequence[Point]
    label: tuple[str, ...] = ()
    label_at: Point = (0.0, 0.0)
    anchor: str = "middle"

    def svg(self) -> str:
        """Return the line and its label."""
        points = " ".join(f"{x},{y}" for x, y in self.through)
        drawn = f'<polyline class="arrow" points="{points}"/>\n'
        x, y = self.label_at
        for number, text in enumerate(self.label):
            drawn += write_line(text, (x, y + LINE_HEIGHT * number), "label", self.anchor)
        return drawn


def write_line(text: str, at: Point, style: str, anchor: str) -> str:
    """Return one line of text."""
    return f'<text class="{style}" x="{at[0]}" y="{at[1]}" text-anchor="{anchor}">{escape(text)}</text>\n'


def figure(size: Point, title: str, parts: Sequence[Box | Arrow]) -> str:
    """Return a whole SVG file; ``title`` is read aloud in place of the figure."""
    width, height = size
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">\n'
    ground = f'<rect class="ground" x="1" y="1" width="{width - 2}" height="{height - 2}" rx="10"/>\n'
    return head + f"<title>{escape(title)}</title>\n" + STYLE + ground + "".join(p.svg() for p in parts) + "</svg>\n"
