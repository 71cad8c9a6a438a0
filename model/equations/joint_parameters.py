"""The parameter table of a joint: rows of body, drive and spring; friction laws have rows of their own.

`Row` holds defaults for revolute and prismatic joints; `quantities` converts rows to `Quantity`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from haptid.model.equations.quantity import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One row of the parameter table of a joint, for revolute and prismatic joints.

    Parameters
    ----------
    id
        Name of the parameter.
    unit, prismatic_unit
        SI unit for a revolute and for a prismatic joint.
    description
        Words for a reader.
    initial, lower, upper
        Default first guess and range, in either unit.
    structured
        FMI structured name below the joint.
    scale
        ``log`` or ``linear``, as in `Quantity`.
    fixed
        Whether the parameter is known by default.
    """

    id: str
    unit: str
    prismatic_unit: str
    description: str
    initial: float
    lower: float
    upper: float
    structured: str
    scale: str = "log"
    fixed: bool = False


TABLE = (
    Row(
        id="inertia",
        unit="kg m^2",
        prismatic_unit="kg",
        description="inertia at the joint in the posture of the test",
        initial=1e-3,
        lower=1e-7,
        upper=1e2,
        structured="inertia",
    ),
    Row(
        id="gravity_cos",
        unit="N m",
        prismatic_unit="N",
        description="gravity torque at q = 0",
        initial=0.0,
        lower=-1e3,
        upper=1e3,
        structured="gravity_cos",
        scale="linear",
    ),
    Row(
        id="gravity_sin",
        unit="N m",
        prismatic_unit="N",
        description="gravity torque at q = pi/2",
        initial=0.0,
        lower=-1e3,
        upper=1e3,
        structured="gravity_sin",
        scale="linear",
    ),
    Row(
        id="Kp",
        unit="1",
        prismatic_unit="1",
        description="plant gain (gearing and amplifier)",
        initial=1.0,
        lower=1e-3,
        upper=1e3,
        structured="actuator.Kp",
        fixed=True,
    ),
    Row(
        id="Ks",
        unit="N m/rad",
        prismatic_unit="N/m",
        description="cable-drag spring",
        initial=1e-2,
        lower=0.0,
        upper=1e4,
        structured="spring.Ks",
        scale="linear",
    ),
    Row(
        id="epos",
        unit="rad",
        prismatic_unit="m",
        description="equilibrium position of the spring",
        initial=0.0,
        lower=-10.0,
        upper=10.0,
        structured="spring.epos",
        scale="linear",
    ),
)

DRIVE_TABLE = (
    Row(
        id="torque_constant",
        unit="N m/A",
        prismatic_unit="N/A",
        description="torque per ampere at the joint, and back-EMF",
        initial=0.1,
        lower=1e-4,
        upper=1e3,
        structured="drive.torque_constant",
    ),
    Row(
        id="resistance_ohm",
        unit="V/A",
        prismatic_unit="V/A",
        description="winding resistance",
        initial=5.0,
        lower=1e-3,
        upper=1e4,
        structured="drive.resistance",
    ),
)
"""Parameters of the drive; one of a current has the first alone."""


def quantities(rows: Iterable[Row], *, prismatic: bool = False) -> tuple[Quantity, ...]:
    """Return rows of the table as parameters with default ranges.

    Parameters
    ----------
    rows
        Rows of `TABLE` or of a friction law.
    prismatic
        Whether the joint slides, which chooses the units.

    Returns
    -------
    tuple of Quantity
        One parameter for each row, in the same order.
    """
    return tuple(
        Quantity(
            id=row.id,
            unit=row.prismatic_unit if prismatic else row.unit,
            description=row.description,
            initial=row.initial,
            lower=row.lower,
            upper=row.upper,
            scale=row.scale,
            fixed=row.fixed,
            structured=row.structured,
        )
        for row in rows
    )


def sliding(unit: str) -> str:
    """Convert a revolute joint's unit to the prismatic joint's: torque becomes force, angle becomes length.

    Parameters
    ----------
    unit
        SI unit of a revolute joint, as ``N m s/rad``.

    Returns
    -------
    str
        SI unit of a prismatic joint, as ``N s/m``.
    """
    return unit.replace("kg m^2", "kg").replace("N m", "N").replace("rad", "m")
