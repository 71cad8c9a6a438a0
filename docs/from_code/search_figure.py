"""Draw the steps of the search for missing physics; the numbers are those of ``docs/theory/missing_physics.md``."""

from __future__ import annotations

import click

from docs.parts.drawing import Arrow, Box, figure
from haptid.support.files.files import write_text
from haptid.support.installing.environment import ROOT

FIGURE = ROOT / "docs" / "images" / "search.svg"
SIZE = (230.0, 54.0)


def box(x: float, y: float, title: str, line: str, kind: str = "package") -> Box:
    """Return a step."""
    return Box(at=(x, y), size=SIZE, title=title, lines=(line,), kind=kind)


def down(x: float, y: float, label: str = "") -> Arrow:
    """Return an arrow from the foot ``y`` of a box to the next one below."""
    middle = x + SIZE[0] / 2
    return Arrow(through=[(middle, y), (middle, y + 32)], label=(label,), label_at=(middle + 7, y + 20), anchor="start")


def up(x: float, y: float, label: str = "") -> Arrow:
    """Return an arrow from the head ``y`` of a box to the next one above."""
    middle = x + SIZE[0] / 2
    return Arrow(through=[(middle, y), (middle, y - 32)], label=(label,), label_at=(middle + 7, y - 12), anchor="start")


def search_flow() -> str:
    """Return the figure."""
    left, middle, right = 40.0, 440.0, 800.0
    parts: list[Box | Arrow] = [
        box(left, 30, "1 Study", "runs, equations, catalogue", "file"),
        box(left, 118, "2 Nominal fit", "homotopy from several starts"),
        box(left, 206, "3 Inner step · 4 Noise", "h,  C = A + Σ s² M Mᵀ"),
        box(left, 294, "5 Omnibus test", "is there a gap?", "choice"),
        box(left, 382, "6 Score tests · 7 Where", "which signature, which region"),
        box(middle, 382, "8 Refit candidates", "base, effect and noise together"),
        box(middle, 294, "9 Only noise left?", "fitted runs, unseen runs, each run", "choice"),
        box(middle, 206, "11 Backward elimination", "leave out, exchange"),
        box(middle, 118, "12 Better nominal fit?", "from the winner's optimum", "choice"),
        box(middle, 30, "13 Finer step · 14 Contenders", "what comes near, at its own step"),
        box(right, 30, "15 Verdict", "16 standard errors", "choice"),
        box(right, 150, "named", "19 rebuild the FMU, refit", "end"),
        box(right, 222, "ambiguous", "17 the run that would tell", "end"),
        box(right, 294, "unlisted", "18 the missing torque as a function", "end"),
        box(right, 382, "nothing missing", "the residual is noise", "end"),
        *(down(left, y) for y in (84, 172, 260)),
        down(left, 348, "gap"),
        Arrow(through=[(left + 230, 409), (middle - 2, 409)]),
        up(middle, 382),
        Arrow(
            through=[(middle, 321), (355, 321), (355, 396), (left + 232, 396)],
            label=("10  no: add", "an effect"),
            label_at=(362, 342),
            anchor="start",
        ),
        up(middle, 294, "yes, or no entry helps"),
        up(middle, 206),
        Arrow(
            through=[(middle, 145), (355, 145), (355, 233), (left + 232, 233)],
            label=("yes",),
            label_at=(398, 138),
        ),
        up(middle, 118, "no"),
        Arrow(through=[(middle + 230, 57), (right - 2, 57)]),
        Arrow(through=[(right, 70), (760, 70), (760, 177), (right - 2, 177)]),
        Arrow(through=[(760, 177), (760, 249), (right - 2, 249)]),
        Arrow(through=[(760, 249), (760, 321), (right - 2, 321)]),
        Arrow(
            through=[(left, 321), (20, 321), (20, 462), (right + 115, 462), (right + 115, 438)],
            label=("no gap",),
            label_at=(480, 456),
        ),
    ]
    return figure((1070, 480), "Steps of the search for missing physics, from the runs to a verdict", parts)


@click.command()
def main() -> None:
    """Draw the figure."""
    write_text(FIGURE, search_flow())
    click.echo(FIGURE.relative_to(ROOT))


if __name__ == "__main__":
    main()
