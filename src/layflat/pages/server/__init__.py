"""Server of pages, only for browsers that have the start link."""

from layflat.pages.server.place import Endpoint
from layflat.pages.server.serve import serve

__all__ = ["Endpoint", "serve"]
