"""Arms of other packages, imported, exported, and read back by other tools: `make conformance`."""
