"""Research: searches and measurements behind what layflat ships; see README.md."""
