"""The axes that a caller brings."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from haptid.api.shown import axes_or_new
from haptid.support.errors import InputError


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (Figure(), "got one Figure; give figure.gca()"),
        (Figure().subfigures(), "got one SubFigure; give figure.gca()"),
        (Figure().subplots(2), "got one ndarray; of several axes give one, as axes[0] of"),
    ],
)
def test_what_is_no_axes_is_refused_with_what_to_give(given: object, told: str):
    """A figure ended in an AttributeError."""
    with pytest.raises(InputError) as caught:
        axes_or_new(given)  # type: ignore[arg-type] # the mistake is the test
    assert str(caught.value).startswith(f"ax: expected Axes of matplotlib, {told}")


def test_given_axes_are_drawn_on():
    axes = Figure().gca()
    assert axes_or_new(axes) is axes
