"""Figures. Import it lazily: matplotlib takes long to import."""
