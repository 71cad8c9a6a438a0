"""Figures as SVG: the same bytes as matplotlib's own way, which draws twice."""

import io

import numpy as np
import pytest

from haptid.report.common import style as styles
from haptid.report.common.style import figure, style, svg


def drawn(scale):
    with style():
        made = figure(5.0, 4.0)
        upper, lower = made.subplots(2, 1, sharex=True, height_ratios=[2, 1])
        x = np.linspace(1.0, 50.0, 200)
        upper.plot(x, np.sin(x), label="measured")
        upper.set_title("a title\nof two lines")
        upper.set_yscale(scale) if scale == "linear" else lower.set_yscale(scale)
        lower.plot(x, x**2)
        lower.set_xlabel("time [s]")
        made.legend(*upper.get_legend_handles_labels(), loc="outside lower center")
    return made


def saved_by_matplotlib(made):
    stream = io.StringIO()
    made.savefig(stream, format="svg", metadata=styles._NO_METADATA, transparent=True, dpi=styles._RASTER_DPI)
    return stream.getvalue()


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_a_figure_that_is_drawn_once_has_the_bytes_of_one_that_is_drawn_twice(scale, monkeypatch):
    once = svg(drawn(scale))
    monkeypatch.setattr(styles, "_draw_once", saved_by_matplotlib)
    assert once == svg(drawn(scale))


def test_the_layout_has_made_room_for_the_labels():
    made = drawn("linear")
    before = made.axes[0].get_position().bounds
    svg(made)
    assert made.axes[0].get_position().bounds != before
