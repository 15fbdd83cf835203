"""The machines that the paper allows, in place of one: `python -m research.cloud`."""
