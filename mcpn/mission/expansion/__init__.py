"""What flattening writes out: the scope of each copy of a block, and histories of what happens once."""
