"""Ulysse's controller in C, in every form, for tests of what compilers make of it."""

from __future__ import annotations

from typing import Any
from unittest.mock import patch

import pytest

from mcpn.controller import rules
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet
from mcpn.robot.targets import files


@pytest.fixture(scope="module", params=["flat", "hierarchical", "modular", "modular in parts"])
def made(request: pytest.FixtureRequest, ulysse_net: MissionNet) -> tuple[dict[str, str], dict[str, Any]]:
    form, _, parts = request.param.partition(" ")
    with patch.object(rules, "FEW_RULES", 0 if parts else rules.FEW_RULES):
        controller = generate(ulysse_net, form)
    return files(document(controller, ulysse_net), "c"), document(controller, ulysse_net)
