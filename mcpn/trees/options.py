"""What people may say of a behaviour tree that is read: the same for all commands and in Python."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TypedDict


class TreeOptions(TypedDict, total=False):
    """How a behaviour tree is read.

    Args:
        library: Versions of libraries that the tree is for: ``nav2=1.5``.
        main: The tree to execute; by default what the file says, or its only tree that no other uses.
        nodes: Files with a ``TreeNodesModel``, which say what is an action and what a condition.
        faulty_leaves: Whether leaves may crash, so that cut sets name them.
    """

    library: Sequence[str]
    main: str | None
    nodes: Sequence[Path]
    faulty_leaves: bool
