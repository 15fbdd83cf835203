"""Failures put on a virtual rig on purpose: how soon each is found, what is done, and how far things go meanwhile."""
