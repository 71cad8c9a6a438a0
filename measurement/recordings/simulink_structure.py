"""A structure with time, as Simulink logs signals to MATLAB: in as its fields, out with the signals by their labels.

It has a field ``time`` and an array ``signals``, whose elements have ``values``, ``label``, ``dimensions`` and mostly
``blockName``. The label is what the user called the signal.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

TIME, SIGNALS, VALUES, LABEL = "time", "signals", "values", "label"


def name_signals(fields: Mapping[str, Any]) -> Mapping[str, Any]:
    """Name the signals of a structure with time by their labels.

    Parameters
    ----------
    fields
        Values of a structure by the names of its fields.

    Returns
    -------
    Mapping
        The fields, with the values of each signal under its label; a signal without a label of its own stays as it is,
        as ``signals_1`` where there are several. The fields themselves where no signal has one, or the structure is
        another one.
    """
    given = fields.get(SIGNALS)
    signals = given if isinstance(given, list) else [given]
    if not isinstance(fields.get(TIME), np.ndarray) or not all(
        isinstance(one, dict) and isinstance(one.get(VALUES), np.ndarray) for one in signals
    ):
        return fields
    labels = _own_labels(signals, fields)
    if not any(labels):
        return fields
    named = {name: value for name, value in fields.items() if name != SIGNALS}
    for number, (label, signal) in enumerate(zip(labels, signals, strict=True)):
        if label:
            named[label] = signal[VALUES]
        else:
            named[f"{SIGNALS}_{number}"] = signal
    return named


def _own_labels(signals: Sequence[Any], fields: Mapping[str, Any]) -> list[str]:
    """Return the label of each signal; an empty text where it has none, or shares it."""
    labels = [label.strip() if isinstance(label := signal.get(LABEL), str) else "" for signal in signals]
    count = Counter([*labels, *fields, *(f"{SIGNALS}_{number}" for number in range(len(signals)))])
    return [label if count[label] == 1 else "" for label in labels]
