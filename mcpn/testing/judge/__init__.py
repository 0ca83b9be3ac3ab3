"""Missions played by what the page on the language says, without a net: an oracle for templates."""
