"""Views of arms: in the browser, and as pictures."""
