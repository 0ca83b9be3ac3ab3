"""What the activities of a robot are (processes, Python, topics), and the loop that runs them."""
