"""Arms to look at: in the browser, and as pictures."""
