"""Licences of installed distributions: name in, SPDX identifier out, by the metadata or else by the licence's text."""

from __future__ import annotations

import re
from importlib import metadata
from pathlib import Path
from typing import Any

UNKNOWN = "not installed where this was made"
_TEXTS = (
    ("MIT", r"Permission is hereby granted, free of charge, to any person"),
    ("Apache-2.0", r"Apache License\s+Version 2\.0"),
    ("LGPL-3.0", r"GNU LESSER GENERAL PUBLIC LICENSE\s+Version 3"),
    ("GPL-3.0", r"GNU GENERAL PUBLIC LICENSE\s+Version 3"),
    ("MPL-2.0", r"Mozilla Public License Version 2\.0"),
    ("BSD-3-Clause", r"Redistribution and use in source and binary forms.{0,1200}endorse or promote"),
    ("BSD-2-Clause", r"Redistribution and use in source and binary forms"),
    ("Qhull", r"Qhull, Copyright"),
)
"""SPDX identifiers and patterns of their texts; where texts of bundled parts follow, the first text counts."""


def expression(name: str) -> str:
    """Return the SPDX expression in the metadata of an installed distribution; empty where there is none.

    Parameters
    ----------
    name
        Name of the distribution.

    Returns
    -------
    str
        As ``BSD-3-Clause``.

    Raises
    ------
    PackageNotFoundError
        Where the distribution is not installed.
    """
    about = metadata.metadata(name).json
    return str(about.get("license_expression") or "")


def licence(name: str) -> str:
    """Find the licence of an installed distribution.

    The first of these that is there counts: SPDX expression, classifiers, name in the metadata, text in the metadata,
    text of the licence's file.

    Parameters
    ----------
    name
        Name of the distribution.

    Returns
    -------
    str
        SPDX expression or name of the licence.

    Raises
    ------
    PackageNotFoundError
        Where the distribution is not installed.
    """
    about = metadata.metadata(name).json
    classifiers = [c.rpartition(" :: ")[2] for c in about.get("classifier", []) if c.startswith("License ::")]
    own = str(about.get("license", "")).strip()
    lines = own.splitlines() or [""]
    named = lines[0][:80] if not lines[0].startswith("Copyright") else ""
    return expression(name) or ", ".join(classifiers) or named or recognise_licence(own) or _from_files(name)


def recognise_licence(text: str) -> str:
    """Return the SPDX identifier of a licence's text; empty where no known pattern occurs in it.

    Parameters
    ----------
    text
        Text of the licence.

    Returns
    -------
    str
        As ``BSD-3-Clause``; the first pattern in the text counts.
    """
    words = " ".join(text.split())
    places = [(found.start(), n) for n, (_, pattern) in enumerate(_TEXTS) if (found := re.search(pattern, words))]
    return _TEXTS[min(places)[1]][0] if places else ""


def _from_files(name: str) -> str:
    """Read the licence's text, which every wheel has to carry beside its metadata."""
    own = [f for f in metadata.files(name) or () if ".dist-info/" in f.as_posix()]
    files = [f for f in own if re.search("licen[cs]e|copying", f.name, re.IGNORECASE)]
    texts = [Path(str(f.locate())).read_text(encoding="utf-8", errors="replace") for f in files]
    found = [spdx for spdx in map(recognise_licence, texts) if spdx]
    return ", ".join(dict.fromkeys(found)) or "not stated"


def with_licences(bill: dict[str, Any]) -> dict[str, Any]:
    """Add the licence to every component of a CycloneDX bill of materials.

    Parameters
    ----------
    bill
        The bill; it is changed in place.

    Returns
    -------
    dict
        ``bill``, with NOASSERTION for a component that is not installed here.
    """
    for component in bill.get("components", []):
        try:
            spdx, said = expression(component["name"]), licence(component["name"])
        except metadata.PackageNotFoundError:
            spdx, said = "", "NOASSERTION"
        component["licenses"] = [{"expression": spdx}] if spdx else [{"license": {"name": said}}]
    return bill
