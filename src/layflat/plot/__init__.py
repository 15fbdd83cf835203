"""Figures. Import its modules where a figure is drawn: matplotlib takes long to import."""
