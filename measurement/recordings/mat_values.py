"""Variables of a MATLAB file in, their vectors by place out, and arrays of structures and cells element by element.

A reader gives numeric arrays as they are, texts too, structures as dicts, arrays of structures and of cells as lists,
and what it cannot take apart as `Unread`; what else holds no numbers as None. Texts count as the labels of the signals
that Simulink logged alone (`simulink_structure`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from haptid.measurement.recordings.one_run import Place, vectors_of
from haptid.measurement.recordings.simulink_structure import name_signals
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array

Vectors = dict[Place, Array]
"""Vectors by their place, each of shape (n_t,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unread:
    """What a reader cannot take apart.

    Parameters
    ----------
    kind
        What it is, in words.
    name
        Its own name, where the reader knows it under another one.
    """

    kind: str
    name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elements:
    """An array of structures, or cell arrays of one size side by side: element by element.

    Parameters
    ----------
    place
        Structures around it.
    names
        Name of the array, or of each of the cell arrays.
    each
        What each element holds, without arrays of elements in it.
    cells
        Whether these are cell arrays.
    """

    place: Place
    names: tuple[str, ...]
    each: tuple[Parts, ...]
    cells: bool

    @property
    def words(self) -> str:
        """The arrays' names, for the user."""
        return ", ".join(".".join((*self.place, name)) for name in self.names)

    def unread_in(self, number: int) -> dict[str, str]:
        """Name what could not be taken apart in one element, as MATLAB counts them.

        Parameters
        ----------
        number
            Number of the element, from 0.

        Returns
        -------
        dict
            In words, by name.
        """
        return {f"{self.words}({number + 1}).{name}": kind for name, kind in self.each[number].unread.items()}

    def side_by_side(self) -> Parts:
        """Put the vectors of all elements side by side, with the elements' numbers from 0 in their names.

        Returns
        -------
        Parts
            Vectors by their place, and by its name what could not be taken apart.
        """
        joined = Parts()
        for number, parts in enumerate(self.each):
            for inner, values in parts.vectors.items():
                own = (f"{inner[-1]}_{number}",) if self.cells else (f"{self.names[0]}_{number}", *inner)
                joined.vectors[(*self.place, *own)] = values
            joined.unread.update(self.unread_in(number))
        return joined


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What variables hold.

    Parameters
    ----------
    vectors
        Vectors by their place.
    elements
        Arrays whose elements hold vectors.
    unread
        What could not be taken apart, in words, by name.
    """

    vectors: Vectors = field(default_factory=dict)
    elements: list[Elements] = field(default_factory=list)
    unread: dict[str, str] = field(default_factory=dict)


def take_apart(variables: Mapping[str, Any]) -> Parts:
    """Take the variables of a file, or the fields of a structure, apart.

    Parameters
    ----------
    variables
        Values by name, as this module's head has them.

    Returns
    -------
    Parts
        Vectors of structures by the names of both, columns of a matrix as ``name_0``, ``name_1`` ….
    """
    parts = Parts()
    cells: dict[tuple[Place, int], dict[str, list[Any]]] = {}
    for place, value in _leaves(variables):
        if isinstance(value, Unread):
            parts.unread[".".join(place)] = value.kind
        elif isinstance(value, list) and any(isinstance(one, dict) for one in value):
            each = tuple(_flat(one if isinstance(one, dict) else {}) for one in value)
            parts.elements.append(Elements(place=place[:-1], names=place[-1:], each=each, cells=False))
        elif isinstance(value, list):
            cells.setdefault((place[:-1], len(value)), {})[place[-1]] = value
        elif value.ndim > 2 and value.size >= THRESHOLDS.least_rows_of_table:
            parts.unread[".".join(place)] = f"an array of {value.ndim} dimensions"
        else:
            parts.vectors.update({(*place[:-1], own): vector for own, vector in vectors_of(place[-1], value)})
    parts.elements.extend(_side_of_cells(cells))
    # Cells and structures of texts and single numbers are left out, as texts and single numbers are.
    parts.elements[:] = [one for one in parts.elements if any(each.vectors or each.unread for each in one.each)]
    return parts


def _leaves(variables: Mapping[str, Any], place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Yield arrays, lists and what is unread, by their place among structures."""
    for name, value in variables.items():
        if isinstance(value, dict):
            yield from _leaves(name_signals(value), (*place, name))
        elif isinstance(value, np.ndarray | list | Unread):
            yield (*place, name), value


def _side_of_cells(cells: Mapping[tuple[Place, int], Mapping[str, Sequence[Any]]]) -> Iterator[Elements]:
    """Yield the cell arrays of one size in one structure: their elements of one number belong together."""
    for (place, count), arrays in cells.items():
        held = {name: values for name, values in arrays.items() if any(_flat({name: one}).vectors for one in values)}
        each = tuple(_flat({name: values[k] for name, values in held.items()}) for k in range(count))
        yield Elements(place=place, names=tuple(held), each=each, cells=True)


def _flat(variables: Mapping[str, Any]) -> Parts:
    """Take an element apart, the arrays of elements in it side by side."""
    parts = take_apart(variables)
    for one in parts.elements:
        inner = one.side_by_side()
        parts.vectors.update(inner.vectors)
        parts.unread.update(inner.unread)
    return Parts(vectors=parts.vectors, unread=parts.unread)
