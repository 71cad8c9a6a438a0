"""`TorqueStudy` in, `TorqueSearch` out: scan with ripple, candidates by stretches, elimination, rivals."""
