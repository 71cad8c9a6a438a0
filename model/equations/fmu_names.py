"""The names of FMU variables: the whole scheme in one place, from which every name of an FMU is made.

Names are structured as FMI 2.0.4, section 2.2.9, describes: parts joined by dots, the joint first. Parameters and
states bring the rest of their name with them (``friction.Fc``, ``spring.Ks``), beside their unit.
"""

from __future__ import annotations

JOINT = "joint{number}"
"""Prefix of the variables of one joint."""
POSITION, VELOCITY, TORQUE, READING = "position", "velocity", "torque", "reading"
"""Position, velocity, commanded torque and encoder reading of a joint."""
ENCODER_ZERO = "encoder.zero"
"""Reading of a joint's encoder at position 0, where it differs from run to run."""
SPEED, ACTUATOR_TORQUE = "speed", "actuator.torque"
"""Outputs of the whole device."""
CONTROLLER = "controller.{part}"
"""Inputs, outputs and gains of the stated controller of a joint."""
DRIVE = "drive.{part}"
"""Inputs and parameters of the drive of a joint."""
HANDLE = "handle.{what}.{axis}"
"""Force and torque on the handle, its position and its quaternion."""
OBSERVER = "observer.{part}"
"""Gain and measured reading of an identification FMU."""
COUPLING = "coupling.{coefficient}"
"""Coefficients of the locked motion that only several joints together have."""
SLOPE = "{input}_slope"
"""Rate of change of an input within a step."""
DERIVATIVE = "der({state})"
SENSITIVITY = "sensitivity.{output}.{column}"
"""Derivative of an output with respect to a parameter or an initial state."""
SENSITIVITY_SWITCH, INNER_STEP = "sensitivity.enabled", "inner_step"


def of_joint(number: int, part: str) -> str:
    """Return the structured name of a joint's variable.

    Parameters
    ----------
    number
        Number of the joint.
    part
        Name below the joint; an empty one gives the prefix with its dot.

    Returns
    -------
    str
        Structured name, as ``joint4.position``.
    """
    return f"{JOINT.format(number=number)}.{part}"


def is_of_joint(name: str) -> bool:
    """Return whether a structured name begins with the prefix of a joint.

    Parameters
    ----------
    name
        Name of an FMU variable.

    Returns
    -------
    bool
        True for ``joint4.position``, for example.
    """
    return name.startswith(JOINT.format(number=""))
