"""Install what is missing, then run a module: ``support/bootstrap.py [--dev | --extra NAME] [-m module arguments]``.

Readable by any Python 3, so that an old one gets one line to read and not a syntax error.
"""

import sys
from pathlib import Path


def main() -> None:
    """Check the interpreter's version before anything of the project is imported."""
    if sys.version_info < (3, 11):  # noqa: UP036 # the bound in pyproject.toml has not been enforced yet
        found = "{}.{}".format(*sys.version_info[:2])
        sys.stderr.write("error: Python 3.11 or newer is needed, " + sys.executable + " is " + found)
        sys.stderr.write("; give a newer one, as in: make fmu PYTHON=python3.11\n")
        sys.exit(2)
    sys.path[0] = str(Path(__file__).resolve().parent.parent)
    from haptid.support.installing.installation import run_module  # noqa: PLC0415 # needs the version checked and the path set

    run_module(sys.argv[1:])


main()
