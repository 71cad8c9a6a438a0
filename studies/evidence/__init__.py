"""What the studies of the ledger say together: pools by one rule, pages, and the lines of README."""
