"""`Run` and `Campaign`, the frozen values that everything downstream uses, with units and warnings."""
