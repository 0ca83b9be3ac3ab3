"""Questions about missions: verdicts, requirements, causes of failure, risk, comparison."""
