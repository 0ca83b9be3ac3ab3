"""The server for an editor, started."""

from __future__ import annotations

import os
from typing import BinaryIO, cast

import click

from mcpn.errors import LimitError


@click.command()
def lsp() -> None:
    """Serve an editor: the Language Server Protocol on standard input and output (needs mcpn[editor])."""
    try:
        from mcpn.editor.server import Heard, server
    except ModuleNotFoundError as error:
        raise LimitError(f"{error.name} is not installed: pip install 'mcpn[editor]'") from error
    # Of its own, for the server closes them; the command line flushes its own when it ends.
    with os.fdopen(os.dup(0), "rb") as heard, os.fdopen(os.dup(1), "wb") as told:
        server().start_io(cast(BinaryIO, Heard(heard)), told)
