"""``python -m mcpn.cli``."""

from mcpn.cli import main

main()
