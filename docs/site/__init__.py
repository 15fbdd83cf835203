"""The documentation as a site: pages in their order, and references generated from the code."""
