"""Write everything in the pages that scripts make: figures, tables of rooms, keys and constants.

``python -m docs.generate`` after a change of contracts, schemas, parameters or thresholds; the tests compare.
"""

from __future__ import annotations

from docs.from_code import architecture, campaign_file, constants, device_file, friction, outcomes, search_figure


def main() -> None:
    """Run all scripts."""
    for script in (architecture, search_figure, device_file, campaign_file, friction, constants, outcomes):
        script.main(args=[], standalone_mode=False)


if __name__ == "__main__":
    main()
