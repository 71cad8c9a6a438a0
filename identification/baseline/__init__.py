"""`Run`s in, `Baseline` and `Figures` out: the plain model by inverse dynamics, which every fit is held against."""
