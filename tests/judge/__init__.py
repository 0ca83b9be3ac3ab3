"""A judge of missions that draws no net: an interpreter made from ``docs/language.md``, and who it judges."""
