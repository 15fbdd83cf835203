"""Which fruit next, where to, how, and what if a pick fails; from descriptions and what a camera detected alone."""
