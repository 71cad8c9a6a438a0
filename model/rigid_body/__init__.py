"""Device in, rigid-body equations out: Lagrange, Newton-Euler, regressors, base parameters."""
