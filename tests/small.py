"""Small missions that tests write down: those of the kit."""

from mcpn.testing.by_hand import activity as activity
from mcpn.testing.by_hand import hw as hw
from mcpn.testing.by_hand import mission as mission
from mcpn.testing.by_hand import robot as robot
