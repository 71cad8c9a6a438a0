"""Names in the FMU that haptid ships."""

from __future__ import annotations

from collections.abc import Iterable

PREFIX = "joint0"
TORQUE, READING = f"{PREFIX}.torque", f"{PREFIX}.reading"
GROUPS = {"inertia": "", "Ks": "spring.", "epos": "spring."}


def variables(parameters: Iterable[str]) -> list[str]:
    """Return the structured name of each parameter."""
    return [f"{PREFIX}.{GROUPS.get(name, 'friction.')}{name}" for name in parameters]
