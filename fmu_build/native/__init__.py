"""Interface in, C source and binaries for every platform out; the C files lie in `c/`."""
