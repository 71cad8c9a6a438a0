"""Ids of the parameters of free joints: joint numbers in, what ends the ids out."""

from __future__ import annotations

from collections.abc import Sequence


def id_suffixes(joints: Sequence[int]) -> tuple[str, ...]:
    """Return what ends the ids of the parameters of each free joint.

    Parameters
    ----------
    joints
        Numbers of the free joints of a configuration.

    Returns
    -------
    tuple of str
        One a joint, as ``("_0", "_4")``; ``("",)`` for a single joint, whose ids have no number.
    """
    return tuple(f"_{joint}" for joint in joints) if len(joints) > 1 else ("",) * len(joints)
