"""The ledger of blind studies: what was begun, with which plan and code, and how it ended."""
