"""Certificates with changes, as files that are removed again."""

from __future__ import annotations

import json
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any


def entries_of(data: bytes) -> dict[str, Any]:
    """The documents of a certificate, by the name of their entry."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        return {name: json.loads(archive.read(name)) for name in archive.namelist()}


@contextmanager
def rewritten(
    data: bytes, entry: str = "claims.json", change: Callable[[Any], Any] = lambda document: None
) -> Iterator[str]:
    """The path of a file with a certificate in which one document has been changed."""
    entries = entries_of(data)
    change(entries[entry])
    with tempfile.NamedTemporaryFile() as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, document in entries.items():
                archive.writestr(name, json.dumps(document))
        file.flush()
        yield file.name
