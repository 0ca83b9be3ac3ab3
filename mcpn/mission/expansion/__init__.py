"""What flattening writes out: the scope of each copy of a block."""
