"""Other tools on the one stated problem, each in its own process and environment; nothing here is part of haptid."""
