"""Properties of nets from elsewhere: behaviour and structure."""
