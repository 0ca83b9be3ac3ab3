"""What is played at a prompt: a mission event by event, a net transition by transition."""
