"""Claims on what a mission's text says: what it grants, and which behaviour trees it was made of."""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.answers.claims.claim import Claim
from mcpn.mission.model import Mission


def claims_of_text(core: Mission) -> Iterator[Claim]:
    """Whether hardware can fail, as the text says, and whether trees were translated exactly."""
    for hardware in core.declared_hardware:
        yield Claim("granted", (hardware.name,), not hardware.faulty)
    for translated in core.translated:
        yield Claim("tree_exact", (translated.tree,), not translated.approximations)
