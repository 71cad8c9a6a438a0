"""The catalogue of effects: one file per effect, found in the folders beside this one; none is registered by hand.

Python files come in, `Effect` by key goes out.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import ModuleType

from haptid.model.effects.effect import Effect
from haptid.support.errors import InputError


@cache
def catalogue() -> dict[str, Effect]:
    """Return every built-in catalogue effect.

    Returns
    -------
    dict of str to Effect
        Effects by key (``id``, or ``id:variant``), in alphabetical order of the file names, whatever their folder.

    Raises
    ------
    InputError
        Where two effects have the same key.
    """
    here = Path(__file__).parent
    files = sorted(here.glob("*/*.py"), key=lambda p: p.stem)
    names = (f"{__package__}.{p.parent.name}.{p.stem}" for p in files if not p.stem.startswith("_"))
    return _index_by_key(effect for name in names for effect in _effects_of(importlib.import_module(name)))


def load_folder(path: Path) -> dict[str, Effect]:
    """Load the effects of a user's folder.

    Parameters
    ----------
    path
        Folder of ``.py`` files; those that define ``EFFECT`` or ``EFFECTS`` are effects, others are ignored.

    Returns
    -------
    dict of str to Effect
        Effects by key.

    Raises
    ------
    InputError
        Where the folder is missing, a file does not run, no file defines an effect, or two effects have the same key.
    """
    if not path.is_dir():
        raise InputError(str(path), expected="a folder with one Python file per effect", got="no such folder")
    found = _index_by_key(effect for file in sorted(path.glob("*.py")) for effect in _effects_of(_run_file(file)))
    if not found:
        raise InputError(str(path), expected="a Python file that defines EFFECT", got="none")
    return found


def with_folder(path: Path | None) -> dict[str, Effect]:
    """Return the built-in effects together with those of a user's folder.

    Parameters
    ----------
    path
        Folder as for `load_folder`; None for the built-in effects alone.

    Returns
    -------
    dict of str to Effect
        Effects by key; a user's effect replaces the built-in one of the same key.

    Raises
    ------
    InputError
        As `load_folder`.
    """
    return {**catalogue(), **(load_folder(path) if path is not None else {})}


def find_effects(ids: Iterable[str], effects: dict[str, Effect] | None = None) -> tuple[Effect, ...]:
    """Return the effects with given keys.

    Parameters
    ----------
    ids
        Keys; an id without variant stands for the first of its variants.
    effects
        Effects by key among which to look; the built-in catalogue where None.

    Returns
    -------
    tuple of Effect
        One effect for each key, in the same order.

    Raises
    ------
    InputError
        Where a key is unknown; the message lists the known ones.
    """
    known = catalogue() if effects is None else effects
    found = []
    for name in ids:
        match = [e for key, e in known.items() if name in (key, e.id)]
        if not match:
            raise InputError("effect", expected=f"one of {', '.join(known)}", got=repr(name))
        found.append(match[0])
    return tuple(found)


def _run_file(file: Path) -> ModuleType:
    name = f"haptid_user_effect_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise InputError(str(file), expected="a Python file", got="something that cannot be imported")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        got = f"{type(error).__name__}: {error}"
        raise InputError(str(file), expected="a file that defines an Effect", got=got) from error
    return module


def _effects_of(module: ModuleType) -> tuple[Effect, ...]:
    """EFFECT or EFFECTS of a module; nothing where it is a helper."""
    single = getattr(module, "EFFECT", None)
    return (single,) if single is not None else tuple(getattr(module, "EFFECTS", ()))


def _index_by_key(effects: Iterable[Effect]) -> dict[str, Effect]:
    found: dict[str, Effect] = {}
    for effect in effects:
        if effect.key in found:
            raise InputError(effect.key, expected="one entry per key", got="two")
        found[effect.key] = effect
    return found
