"""Iterative learning: a move that is repeated is done better each time, by correcting the demand that is sent."""

from layflat.motion.learning.file import read_learnt, write_learnt
from layflat.motion.learning.learnt import Learnt, Wanted, begin

__all__ = ["Learnt", "Wanted", "begin", "read_learnt", "write_learnt"]
