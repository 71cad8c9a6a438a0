"""Values that a fit leaves on the constraint Fs = Fc: the FMU starts with them, or is not written."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy import simulate_fmu

from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError

LEVEL = 0.0548853


@pytest.mark.parametrize("hair", [1e-15, 8e-8, 3e-6])
def test_an_fmu_starts_where_stiction_lies_a_hair_below_coulomb_friction(tmp_path, hair):
    values = {"Fs": LEVEL * (1 - hair), "Fc": LEVEL}
    fmu = build_fmu(joint_equations(4), tmp_path / "a.fmu", kind="native", values=values, platforms=this_platform())
    result = simulate_fmu(fmu.path, stop_time=0.02)
    assert len(result) > 10
    assert all(np.isfinite(result[name]).all() for name in result.dtype.names)


def test_no_fmu_is_written_that_could_not_start(tmp_path):
    out = tmp_path / "a.fmu"
    with pytest.raises(InputError, match=r"expected Fs >= Fc, got Fs = 0\.5, Fc = 1"):
        build_fmu(joint_equations(4), out, kind="native", values={"Fs": 0.5, "Fc": 1.0}, platforms=this_platform())
    assert not out.exists()
