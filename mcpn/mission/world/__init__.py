"""Facts of the world: conditions on them, and what a file may say wrongly of them."""
