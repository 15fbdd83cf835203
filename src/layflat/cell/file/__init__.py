"""What packing cell this is: description files and validated objects."""
