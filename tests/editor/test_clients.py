"""What is wrong in a mission as it is typed, by two clients that share no code: words and lines of check."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest

from mcpn.editor.scan import scan
from mcpn.errors import InputError
from mcpn.mission.xml import read_mission
from tests.editor.client import Client
from tests.mission.test_broken import BROKEN

pytest.importorskip("pygls", reason="needs mcpn[editor]")

SERVER = [sys.executable, "-m", "mcpn.cli", "lsp"]
RIGHT = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><hardware name="h"/><activity name="a" consumes="h"/></robot>
<objective name="o" activities="a"/>
</mission>
"""
ERROR = 1
Shown = list[tuple[int, str]]


def typed() -> dict[str, str]:
    """Every seeded error of a file that begins as a mission does."""
    roots = {name: next((e.tag for e in scan(text)), "") for name, (text, *_) in BROKEN.items()}
    return {name: BROKEN[name][0] for name, root in roots.items() if root == "mission"}


def by_check(path: Path, text: str) -> Shown:
    """Lines and words of what check finds wrong in a file that holds a text."""
    path.write_text(text)
    try:
        read_mission(path)
    except InputError as error:
        return sorted(((p.source and p.source.line) or 1, p.message) for p in error.problems)
    return []


def by_a_client_in_forty_lines(path: Path, texts: list[str]) -> list[Shown]:
    client = Client()
    uri, found = path.as_uri(), []
    client.open(path, RIGHT)
    for version, text in enumerate(texts, 2):
        document = {"uri": uri, "version": version}
        client.tell("textDocument/didChange", textDocument=document, contentChanges=[{"text": text}])
        # Who answers has told before what is wrong.
        client.ask("textDocument/hover", textDocument={"uri": uri}, position={"line": 0, "character": 0})
        shown = [d for d in client.diagnostics[uri] if d["severity"] == ERROR]
        found.append(sorted((d["range"]["start"]["line"] + 1, d["message"]) for d in shown))
    assert client.close() == 0
    return found


def by_pytest_lsp(path: Path, texts: list[str]) -> list[Shown]:
    api = pytest.importorskip("pytest_lsp", reason="needs pytest-lsp")
    from lsprotocol import types as lsp

    async def asked() -> list[Shown]:
        client, uri, found = api.make_test_lsp_client(), path.as_uri(), []
        await client.start_io(*SERVER)
        await client.initialize_session(
            lsp.InitializeParams(capabilities=lsp.ClientCapabilities(), root_uri=path.parent.as_uri())
        )
        opened = lsp.TextDocumentItem(uri, "xml", 1, RIGHT)
        client.text_document_did_open(lsp.DidOpenTextDocumentParams(opened))
        for version, text in enumerate(texts, 2):
            client.text_document_did_change(
                lsp.DidChangeTextDocumentParams(
                    lsp.VersionedTextDocumentIdentifier(version, uri),
                    [lsp.TextDocumentContentChangeWholeDocument(text)],
                )
            )
            at = lsp.HoverParams(lsp.TextDocumentIdentifier(uri), lsp.Position(0, 0))
            await client.text_document_hover_async(at)
            shown = [d for d in client.diagnostics[uri] if d.severity == lsp.DiagnosticSeverity.Error]
            found.append(sorted((d.range.start.line + 1, d.message) for d in shown))
        await client.shutdown_session()
        await client.stop()
        return found

    return asyncio.run(asked())


@pytest.mark.long
def test_every_seeded_error_is_that_of_check(tmp_path: Path) -> None:
    path = (tmp_path / "mission.xml").resolve()
    broken = typed()
    assert len(broken) > 100
    expected = [by_check(path, text) for text in broken.values()]
    path.write_text(RIGHT)
    # The client of others asks about some: what it may see differently is how messages are framed.
    for asked, share in ((by_a_client_in_forty_lines, 1), (by_pytest_lsp, 5)):
        names = list(broken)[::share]
        found = asked(path, [*(broken[name] for name in names), RIGHT])
        assert found.pop() == []
        assert dict(zip(names, found, strict=True)) == dict(zip(names, expected[::share], strict=True)), asked
