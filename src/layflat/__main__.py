"""Command line by `python -m layflat`, for where its program is not on the path."""

from layflat.cli import main

main()
