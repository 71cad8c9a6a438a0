"""Ends of the ids of parameters."""

from __future__ import annotations

import pytest

from haptid.model.device.reader import load_device
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.joint.coupled_joints import configuration_equations


@pytest.mark.parametrize("joints", [(0,), (4,), (0, 1), (1, 4)])
def test_the_equations_of_a_configuration_have_the_ids_that_the_suffixes_give(joints):
    equations = configuration_equations(load_device("freedom6s"), joints)
    suffixes = id_suffixes(joints)
    assert len(suffixes) == len(joints)
    for suffix in suffixes:
        assert equations.parameter(f"Ks{suffix}").id == f"Ks{suffix}"


def test_equations_without_joints_have_no_suffix():
    assert id_suffixes(()) == ()
