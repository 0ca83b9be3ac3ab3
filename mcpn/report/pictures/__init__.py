"""Pictures: a mission as it is written, by a layout of its own; graphs, by Graphviz."""
