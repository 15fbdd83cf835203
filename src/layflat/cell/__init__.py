"""The packing cell: produce is seen through a camera, picked by the arm, and packed."""
