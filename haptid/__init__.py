"""haptid: measurements of a robot or haptic device in, identified FMUs with honest uncertainty out.

In a clone the packages lie at the top level and this folder holds links to them; a wheel holds the packages here.
Where a checkout cannot make links (git writes text files in their place), the clone's root is searched as well.
"""

from pathlib import Path

_CLONE = Path(__file__).resolve().parent.parent
if (_CLONE / "pyproject.toml").is_file() and not (_CLONE / "haptid" / "model").is_dir():
    __path__.append(str(_CLONE))
