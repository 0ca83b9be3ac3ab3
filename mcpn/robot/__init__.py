"""The robot's side: it reads the controller's document, and knows nothing of missions."""
