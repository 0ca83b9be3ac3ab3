"""Commands around a controller: its run, the bench, sequences of events, monitors."""
