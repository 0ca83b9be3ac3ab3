"""What names in formulas mean, told by the judge's own writing out of blocks."""

from __future__ import annotations

from mcpn.mission.model import Mission, Use, walk
from mcpn.testing.judge.blocks import WrittenBlock, written_out

Path = tuple[str, ...]
"""The uses of protocols in which a block stands, then its name: all of it as written."""


def paths(mission: Mission) -> dict[str, list[Path]]:
    """By qualified name of an objective the blocks that it stands in and itself, from without, as written."""
    found: dict[str, list[Path]] = {}

    def descend(node: WrittenBlock, uses: Path, around: list[Path]) -> None:
        if not node.copy:
            around = [*around, (*uses, node.written)]
        if not node.children:
            found[node.name] = around
        for child in node.children.values():
            descend(child, around[-1] if node.use else uses, around)

    for child in written_out(mission).children.values():
        descend(child, (), [])
    return found


def meant(mission: Mission, *, blocks: bool = False) -> dict[Path, set[str]]:
    """By a block as it is written the objectives that its name means.

    Args:
        mission: A valid mission.
        blocks: Whether it means what it holds, as ``block(x)`` does, or an objective and its copies alone.
    """
    found: dict[Path, set[str]] = {}
    for name, chain in paths(mission).items():
        for path in chain if blocks else chain[-1:]:
            found.setdefault(path, set()).add(name)
    return found


def in_all_uses(mission: Mission) -> dict[tuple[str, str], set[str]]:
    """By the text that holds an objective, empty for the mission, and its name there, all copies of it."""
    texts = {"": mission.blocks, **{protocol.name: protocol.blocks for protocol in mission.protocols}}
    found: dict[tuple[str, str], set[str]] = {}
    for (*uses, name), copies in meant(mission).items():
        text = ""
        for use in uses:
            (text,) = (b.protocol for b in walk(texts[text]) if isinstance(b, Use) and b.name == use)
        found.setdefault((text, name), set()).update(copies)
    return found


def ambiguous(mission: Mission) -> list[str]:
    """Objectives that have copies under other names, and one that is called as it is written."""
    return [
        name for path, names in meant(mission).items() if (name := ".".join(path)) in names and len(names) > 1
    ]
