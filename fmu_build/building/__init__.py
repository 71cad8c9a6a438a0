"""`Equations` in, `Fmu` file out, built once and kept in the cache."""
