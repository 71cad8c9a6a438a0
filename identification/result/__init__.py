"""`Fit`: the frozen result, and how it ended in words."""
