"""Description of a packing cell: files and validated objects."""
