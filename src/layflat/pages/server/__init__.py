"""How pages are served: to the people who have the start link, and to nobody else."""

from layflat.pages.server.place import Place
from layflat.pages.server.serve import serve

__all__ = ["Place", "serve"]
