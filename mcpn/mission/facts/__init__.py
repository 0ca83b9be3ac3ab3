"""Static facts of a mission: who uses, shares and hands over what, found before any state is explored."""
