"""Problem in, minima out: Levenberg-Marquardt, SLSQP, homotopy, starts."""
