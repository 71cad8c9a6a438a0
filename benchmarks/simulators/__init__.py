"""Other simulators on what haptid writes: clients of FMUs, and simulators of rigid bodies."""
