"""Version of the program that makes blind cases: digest of its code, comments and docstrings left out."""

from __future__ import annotations

import ast
import hashlib
import io
import subprocess
import tarfile
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]
MAKER = ("virtual_device", "studies/hidden")
"""Folders of the code that decides what a case hides, and how large."""
SUFFIXES = (".py", ".c", ".h", ".toml")


def generator_digest(root: Path = ROOT) -> str:
    """Return the version of the generator in a checkout.

    Parameters
    ----------
    root
        Folder of the checkout.

    Returns
    -------
    str
        Twelve hex digits.
    """
    paths = [path for folder in MAKER for path in (root / folder).rglob("*") if path.suffix in SUFFIXES]
    return digest_of({path.relative_to(root).as_posix(): path.read_text(encoding="utf-8") for path in paths})


def generator_at(version: str, root: Path = ROOT) -> str | None:
    """Return the version of the generator in a commit.

    Parameters
    ----------
    version
        As ``git describe`` says it; what was not committed there cannot be seen.
    root
        Folder of the checkout.

    Returns
    -------
    str or None
        Twelve hex digits; None where git does not know the commit.
    """
    commit = version.removesuffix("-dirty")
    listed = _git(root, "ls-tree", "-d", "--name-only", commit, *MAKER)
    folders = listed.decode().split() if listed else []
    packed = _git(root, "archive", commit, *folders) if folders else None
    if packed is None:
        return None
    texts = {}
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        for member in archive:
            content = archive.extractfile(member) if member.name.endswith(SUFFIXES) else None
            if content is not None:
                texts[member.name] = content.read().decode("utf-8")
    return digest_of(texts)


def digest_of(texts: Mapping[str, str]) -> str:
    """Return the digest of sources.

    Parameters
    ----------
    texts
        Content by path.

    Returns
    -------
    str
        Twelve hex digits of the SHA-256 of paths and code; words that no program reads do not change it.
    """
    found = hashlib.sha256()
    for path in sorted(texts):
        code = code_of(texts[path]) if path.endswith(".py") else texts[path]
        found.update(f"{path}\n{code}\n".encode())
    return found.hexdigest()[:12]


def code_of(source: str) -> str:
    r"""Return Python source without docstrings, blank lines and lines of comment.

    Parameters
    ----------
    source
        Python source.

    Returns
    -------
    str
        Lines of code as they stand there.

    Examples
    --------
    >>> code_of("# why\nx = 1\n'''What x is.'''\n")
    'x = 1'
    """
    words: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            words.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    lines = [line.rstrip() for number, line in enumerate(source.splitlines(), 1) if number not in words]
    return "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))


def _git(root: Path, *command: str) -> bytes | None:
    """Return what git answers; None where it refuses or is absent."""
    try:
        done = subprocess.run(["git", *command], cwd=root, capture_output=True, check=False)
    except FileNotFoundError:
        return None
    return done.stdout if done.returncode == 0 else None
