"""The smallest detectable size is the one that a test finds as often as it says."""

import numpy as np
import pytest
from scipy.stats import chi2

from haptid.discrepancy.detect.detectable import noncentrality, smallest
from haptid.discrepancy.detect.signatures import Point
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales

EFFECTS = {key: catalogue()[key].at(Scales(torque=0.01)) for key in ("cubic_spring", "cogging")}


@pytest.mark.parametrize("dof", [1, 2])
@pytest.mark.parametrize("tests", [1.0, 300.0])
def test_power_by_drawing(dof: int, tests: float):
    rng = np.random.default_rng(0)
    shift = np.zeros(dof)
    shift[0] = np.sqrt(noncentrality(dof, tests))
    T = np.sum((rng.standard_normal((40_000, dof)) + shift) ** 2, axis=1)
    family = -np.expm1(tests * np.log1p(-chi2.sf(T, dof)))
    assert np.mean(family < THRESHOLDS.detect.detected_family_wise_p_value) == pytest.approx(
        THRESHOLDS.detect.detection_power, abs=0.01
    )


def test_sizes_scale_with_the_signature_and_the_best_shape_counts():
    k3 = EFFECTS["cubic_spring"].parameters[0].initial
    a, n = (EFFECTS["cogging"].parameters[i].initial for i in (0, 2))
    points = [
        Point(key="cubic_spring", values=({"k3": k3},), columns=slice(0, 1)),
        *(
            Point(
                key="cogging",
                values=({"cogging_sin": a, "cogging_number": n}, {"cogging_cos": a, "cogging_number": n}),
                columns=slice(at, at + 2),
            )
            for at in (1, 3)
        ),
    ]
    G = np.diag([4.0, 1.0, 1.0, 9.0, 9.0])
    cogging, spring = smallest(points, G, 50.0, EFFECTS)
    assert spring.size == pytest.approx(k3 * np.sqrt(noncentrality(1, 50.0)) / 2.0)
    assert cogging.size == pytest.approx(a * np.sqrt(noncentrality(2, 50.0)) / 3.0)
    assert (spring.unit, cogging.parameter) == ("N m/rad^3", "cogging_sin")
