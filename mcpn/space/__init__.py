"""State spaces: markings graphs and alternatives graphs, explicit, symbolic and by composition."""
