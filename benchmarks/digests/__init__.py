"""Digests of results: whether a change of the code has left every bit of them as it was.

    python -m benchmarks.digests [--only NAME ...] [--out build/digests.json] [--against REVISION|FILE.json]

Every item simulates something small and stores its results as arrays of float64 under names of its own, so that a name
in the code may change while its result is still found again. A digest is the SHA-256 of such an array's bytes. With
`--against`, another revision's own copy of this script runs in a temporary worktree, and the table says what differs.
Revision e6b4efd holds the first copy, on the code as it was before its rooms were rebuilt.
"""
