"""Questions about missions and nets: verdicts, temporal logic, causes of failure, properties of nets."""
