"""Pictures of a mission, made without any program or library for drawing."""
