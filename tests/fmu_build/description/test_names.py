"""Every variable of an FMU bears a name of the one scheme."""

from __future__ import annotations

import re

import pytest

from haptid.fmu_build.description.interface import interface_of
from haptid.model.device.reader import load_device
from haptid.model.equations import fmu_names
from haptid.model.equations.equations import Equations
from haptid.model.equations.output_injection import with_observer
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.generate import generate
from haptid.support.installing.environment import ROOT

SCHEME = (
    fmu_names.JOINT + ".{part}", fmu_names.HANDLE, fmu_names.COUPLING, fmu_names.SENSITIVITY,
    fmu_names.SENSITIVITY_SWITCH, fmu_names.INNER_STEP, "{link}.{parameter}",
)  # fmt: skip
WRAPPED = (fmu_names.DERIVATIVE, fmu_names.SLOPE)


def pattern(name: str) -> str:
    """Return a scheme as a regular expression: its fields are words, or parts joined by dots at the end."""
    return re.sub(r"\\\{\w+\\\}", r"[\\w.]+", re.escape(name))


NAMES = "|".join(map(pattern, SCHEME))
ANY = re.compile("|".join((NAMES, *(pattern(w).replace(r"[\w.]+", f"(?:{NAMES})", 1) for w in WRAPPED))))


def names_of(equations: Equations, *, identification: bool) -> list[str]:
    found = interface_of(
        generate(equations), identifier="x", identification=identification, derivatives=not identification, values={}
    )
    return [v.name for v in found.variables]


@pytest.mark.parametrize(
    ("equations", "identification"),
    [
        (joint_equations(4), False),
        (with_observer(joint_equations(4)), True),
        (full_equations(load_device("freedom6s")), False),
    ],
)
def test_every_variable_is_named_by_the_scheme(equations: Equations, identification: bool):
    names = names_of(equations, identification=identification)
    assert [name for name in names if not ANY.fullmatch(name)] == []
    assert len(set(names)) == len(names)


def test_what_belongs_to_a_joint_says_so():
    plain = [name.removeprefix("der(") for name in names_of(joint_equations(4), identification=False)]
    assert [name for name in plain if not fmu_names.is_of_joint(name)] == []


def test_the_pages_name_variables_that_exist():
    page = (ROOT / "docs" / "how-to" / "other_simulators.md").read_text(encoding="utf-8")
    written = set(re.findall(r"[`']joint4\.((?!fmu)[\w.]+)[`']", page))
    names = names_of(full_equations(load_device("freedom6s")), identification=False)
    assert written >= {fmu_names.TORQUE, fmu_names.READING}
    assert {fmu_names.of_joint(4, part) for part in written} <= set(names)
