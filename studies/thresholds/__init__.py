"""Study of halving and doubling each threshold: what changes in a panel of fixed cases."""
