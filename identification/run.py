"""``python -m identification.run [CAMPAIGN]``: fits in locking order, coupled test, verification, export.

Worker processes import this module, as the one that was started: it loads no more than the command's options.
"""

from __future__ import annotations

from haptid.identification.commands import identify as main

if __name__ == "__main__":
    main()
