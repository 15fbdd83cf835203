"""Design, simulate and control robot joints made of layflat hose."""

__version__ = "0.1.0"
