"""What a mistyped name may have meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Suggest names for a mistyped one.

    Parameters
    ----------
    name
        Name as the user wrote it.
    known
        Names that exist.

    Returns
    -------
    str
        Question with the one or two most similar names; a list of all names where none is similar.
    """
    names = list(known)
    near = get_close_matches(name[:80], names, n=2, cutoff=0.6)  # comparing long texts is slow
    return f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(names)}"
