"""Results in, figures and pages out; computes nothing."""
