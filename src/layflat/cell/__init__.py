"""The packing cell: produce is seen, picked and packed."""
