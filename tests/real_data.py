"""Where the real measurements are: beside the checkout, or in the folder that HAPTID_DATA names."""

import os
from pathlib import Path

DATA = Path(os.environ.get("HAPTID_DATA") or Path(__file__).parents[2] / "shared" / "data")
