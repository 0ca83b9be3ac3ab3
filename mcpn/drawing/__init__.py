"""Missions drawn as nets: templates, composition, the nets of sections."""
