"""`Equations` in, `CompiledKernel` out: C source, compilation, calls."""
