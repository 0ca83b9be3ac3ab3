"""The controller: a finite state machine made from the alternatives graph."""
