"""Friction laws of the virtual device by name: the numbers by which ``friction.h`` knows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from haptid.support.errors import InputError

LAWS = ("lugre", "dahl", "maxwell_slip")
"""Friction laws, in the order of their numbers in ``friction.h``; a joint of which nothing is said has the first."""
OF_LAWS = {"law": 0.0, "C": 1.0, "spread": 2.0, "unevenness": 1.0, "n": 1.0}
"""The law's number, and what Maxwell-slip and Dahl friction have beside the parameters of LuGre."""
ATTRACTION = 40.0
"""Attraction C of Maxwell-slip friction over Fc [1/s]: its level follows the speed within some 25 ms."""


def law_number(friction: str) -> dict[str, float]:
    """Return the parameter that chooses a friction law by name.

    Parameters
    ----------
    friction
        Name of the law, one of `LAWS`.

    Returns
    -------
    dict of str to float
        ``law`` → the law's number in ``friction.h``.

    Raises
    ------
    InputError
        Where there is no such law.
    """
    if friction not in LAWS:
        raise InputError(where="friction", expected=f"one of {', '.join(LAWS)}", got=repr(friction))
    return {"law": float(LAWS.index(friction))}


def law_parameters(friction: str, coulomb: float) -> dict[str, float]:
    """Return the parameters `OF_LAWS` of a friction law.

    Parameters
    ----------
    friction
        Name of the law, one of `LAWS`.
    coulomb
        Coulomb friction [N m].

    Returns
    -------
    dict of str to float
        Number of the law, attraction C [N m/s], spread, unevenness and exponent n, by name.

    Raises
    ------
    InputError
        Where there is no such law.
    """
    return OF_LAWS | law_number(friction) | {"C": ATTRACTION * coulomb}


def parse_friction(text: str, joints: Sequence[int], option: str = "--friction") -> dict[int, str]:
    """Read ``dahl``, the law of all ``joints``, or ``2=dahl,4=maxwell_slip``, the laws of some of them.

    Parameters
    ----------
    text
        Value of the option.
    joints
        Numbers of the joints that may have a law.
    option
        Name of the option in errors.

    Returns
    -------
    dict of int to str
        The law by joint, for those that do not have the first of `LAWS`.

    Raises
    ------
    InputError
        Where there is no such law or joint, or a joint is named twice.
    """
    if text in LAWS:
        return _without_first(dict.fromkeys(joints, text))
    chosen: dict[int, str] = {}
    for part in text.split(","):
        number, _, law = part.partition("=")
        joint = int(number) if number.isdecimal() else -1
        if joint not in joints or joint in chosen or law not in LAWS:
            among = ", ".join(map(str, joints))
            expected = f"one of {', '.join(LAWS)}, or each joint's once as {joints[0]}=dahl, joints among {among}"
            raise InputError(where=option, expected=expected, got=repr(part))
        chosen[joint] = law
    return _without_first(chosen)


def _without_first(laws: Mapping[int, str]) -> dict[int, str]:
    return {joint: law for joint, law in laws.items() if law != LAWS[0]}
