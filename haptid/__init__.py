"""A `Campaign` of measurements in; `Identified` FMUs, `Posteriors` and `Missing` effects out: one name for all.

    from haptid import Campaign

    identified = Campaign.read("my_campaign").identify()

In a clone the packages lie at the top level and this folder holds links to them; a wheel holds the packages here.
Where a checkout cannot make links (git writes text files in their place), the clone's root is searched as well.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from haptid.api.campaign import Campaign as Campaign
    from haptid.api.identified import Identified as Identified
    from haptid.api.missing import Missing as Missing
    from haptid.api.posteriors import Posteriors as Posteriors
    from haptid.identification.problem.options import FitOptions as FitOptions
    from haptid.support.errors import HaptidError as HaptidError
    from haptid.support.errors import InputError as InputError
    from haptid.support.errors import NumericalError as NumericalError

_CLONE = Path(__file__).resolve().parent.parent
if (_CLONE / "pyproject.toml").is_file() and not (_CLONE / "haptid" / "model").is_dir():
    __path__.append(str(_CLONE))

_PUBLIC = {
    "Campaign": "haptid.api.campaign",
    "Identified": "haptid.api.identified",
    "Posteriors": "haptid.api.posteriors",
    "Missing": "haptid.api.missing",
    "FitOptions": "haptid.identification.problem.options",
    "HaptidError": "haptid.support.errors",
    "InputError": "haptid.support.errors",
    "NumericalError": "haptid.support.errors",
}
"""Module of each public name: imported when it is asked for, as the commands' help needs none of them."""


def __getattr__(name: str) -> Any:
    """Import a public name; ``__version__`` is looked up when it is asked for."""
    if name == "__version__":
        return import_module("haptid.version").version()
    if name not in _PUBLIC:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    """Return the names of this module with the public ones."""
    return sorted({*globals(), *_PUBLIC, "__version__"})
