"""Small missions that tests write down: those of the kit."""

from mcpn.testing.shape import activity as activity
from mcpn.testing.shape import hw as hw
from mcpn.testing.shape import mission as mission
from mcpn.testing.shape import robot as robot
