"""Posterior of every joint's parameters: ``python -m uq.run [CAMPAIGN]``.

Worker processes import this module, as the one that was started: it loads no more than the command's options.
"""

from __future__ import annotations

from haptid.uq.commands import posterior as main

if __name__ == "__main__":
    main()
