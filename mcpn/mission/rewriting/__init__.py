"""What passes share: blocks rewritten in their place, copies of them, siblings, and how many there may be."""
