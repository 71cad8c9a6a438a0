"""Stability over bags: an effect that every stretch shows, one that a single stretch shows, and one that none shows."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.discrepancy.fit.stability import Stretches, stability_of
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales

UNIT = Scales()
STRETCHES, ROWS = 16, 200


def stretches_with(size: np.ndarray) -> Stretches:
    """Return a model with an offset and a cubic spring whose torque has ``size`` in each stretch, fitted."""
    draw = np.random.default_rng(3)
    shape = [s * draw.standard_normal(ROWS) for s in size]
    J = [-np.column_stack([np.ones(ROWS), x]) for x in shape]
    y = [x + draw.standard_normal(ROWS) for x in shape]
    normal, target = sum(A.T @ A for A in J), sum(A.T @ r for A, r in zip(J, y, strict=True))
    offset, spring = -np.linalg.solve(normal + 1e-9 * np.eye(2), target)
    left = [r + A @ (offset, spring) for r, A in zip(y, J, strict=True)]
    return Stretches(
        ids=("offset", "k3"), slope=np.ones(2), values={"offset": offset, "k3": spring},
        residuals=tuple(left), jacobians=tuple(J),
        independent=float(STRETCHES * ROWS), prior=np.zeros(0), prior_jacobian=np.zeros((0, 2)),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("size", "least", "most"),
    [
        (np.full(STRETCHES, 1.0), 1.0, 1.0),
        (np.eye(STRETCHES)[4], 0.4, 0.8),
        (np.full(STRETCHES, 1e-3), 0.0, 0.1),
    ],
    ids=["everywhere", "in one stretch", "nowhere"],
)
def test_share_of_bags(size: np.ndarray, least: float, most: float):
    effect = catalogue()["cubic_spring"].at(UNIT)
    assert effect.parameters[0].id == "k3"
    share = stability_of(stretches_with(size), [effect])[effect.key]
    # A single stretch is in a bag with the probability 1 − (1 − 1/16)^16 = 0.64.
    assert least <= share <= most
