"""``python -m discrepancy.run [CAMPAIGN] --joint J``: what is missing in the model of a joint, if anything.

Worker processes import this module, as the one that was started: it loads no more than the command's options.
"""

from __future__ import annotations

from haptid.discrepancy.commands import missing as main

if __name__ == "__main__":
    main()
