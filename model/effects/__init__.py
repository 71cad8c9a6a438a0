"""The catalogue: one file an effect, found by looking into the folders; `registry` returns them by key."""
