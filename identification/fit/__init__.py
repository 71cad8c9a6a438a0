"""Runs of one configuration in, `Fit` out, by whichever strategy the runs allow."""
