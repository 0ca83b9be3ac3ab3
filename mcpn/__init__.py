"""mcpn: a symbolic and compositional verifier of robot missions."""

__version__ = "0.1.0"
