"""Small missions that tests write down: those of the kit."""

from mcpn.testing.small import activity as activity
from mcpn.testing.small import hw as hw
from mcpn.testing.small import mission as mission
from mcpn.testing.small import robot as robot
