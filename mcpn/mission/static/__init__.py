"""The static analysis of a mission: who uses, shares and hands over what, before any state is explored."""
