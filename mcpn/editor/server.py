"""The server: what a client of the Language Server Protocol sends and gets (``mcpn lsp``)."""

from __future__ import annotations

import asyncio
import json
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, cast

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer
from pygls.uris import to_fs_path
from pygls.workspace import TextDocument

from mcpn.editor.answers import SOURCE, Answers
from mcpn.editor.project import Memory, Project
from mcpn.version import VERSION

PAUSE = 0.3
"""For how many seconds nothing is typed before it is looked for what is suspicious."""
MOST_BYTES = 64 << 20
"""Bytes of a message."""
MOST_LINE = 1 << 16
_LENGTH = re.compile(rb"Content-Length: ([0-9]++)\r\n\Z")
SYNC = lsp.TextDocumentSyncKind.Incremental


class MissionServer(LanguageServer):
    """Answers a client about files of missions; what their states say is found beside it after a save."""

    def __init__(self) -> None:
        super().__init__("mcpn", VERSION, text_document_sync_kind=SYNC)
        self.told: dict[Path, set[Path]] = {}
        self.names: dict[str, str] = {}
        self.problems: dict[Path, list[lsp.Diagnostic]] = {}
        self.memory = Memory()
        self.under_way: asyncio.Task[None] | None = None
        self.paused: asyncio.Task[None] | None = None

    def answers(self) -> Answers:
        """Answers about the files as they are typed now."""
        unsaved = {
            path: document.source
            for uri, document in self.workspace.text_documents.items()
            if (path := file_of(uri)) is not None
        }
        project = Project(unsaved, self.memory)

        def document(file: Path) -> TextDocument:
            for uri, known in self.workspace.text_documents.items():
                if file_of(uri) == file:
                    return cast(TextDocument, known)
            return TextDocument(file.as_uri(), project.text(file) or "")

        return Answers(project, document)

    def tell(self, file: Path, *, at_once: bool = False) -> None:
        """Sends the problems of a file and of those that belong to it.

        Args:
            file: The file.
            at_once: Whether what was suspicious before is told, where nothing is wrong.
        """
        found = self.answers().diagnostics(file, at_once=at_once)
        for other in self.told.get(file, set()) - found.keys():
            found[other] = []
        self.told[file] = set(found)
        for other, diagnostics in found.items():
            more = self.problems.get(other, []) if not any(map(_is_error, diagnostics)) else []
            self.text_document_publish_diagnostics(
                lsp.PublishDiagnosticsParams(other.as_uri(), [*diagnostics, *more])
            )

    def tell_typed(self, file: Path) -> None:
        """Sends what is wrong at once, and what is suspicious once nothing is typed."""
        if self.paused is not None:
            self.paused.cancel()
        self.tell(file, at_once=True)
        self.paused = asyncio.ensure_future(self._told(file))

    async def _told(self, file: Path) -> None:
        await asyncio.sleep(PAUSE)
        self.tell(file)

    def explore(self, file: Path) -> None:
        """Begins to find out what the states say, in a process of its own; an older one is ended."""
        if self.under_way is not None:
            self.under_way.cancel()
        self.under_way = asyncio.ensure_future(self._explored(file))

    async def _explored(self, file: Path) -> None:
        for mission in Project({}).missions(file):
            process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "mcpn.editor.shown_states", str(mission)),
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.DEVNULL,
            )
            try:
                out, _ = await process.communicate()
            finally:
                with suppress(ProcessLookupError):
                    process.kill()
            if process.returncode == 0:
                self._found(json.loads(out))
        self.tell(file)

    def _found(self, said: dict[str, Any]) -> None:
        self.names, self.problems = said["names"], {}
        for problem in said["problems"]:
            if problem["file"] is not None:
                line = max(0, (problem["line"] or 1) - 1)
                at = lsp.Range(lsp.Position(line, 0), lsp.Position(line + 1, 0))
                self.problems.setdefault(Path(problem["file"]).resolve(), []).append(
                    lsp.Diagnostic(at, problem["message"], lsp.DiagnosticSeverity.Warning, source=SOURCE)
                )


def file_of(uri: str) -> Path | None:
    """The file of an address; ``None`` where it is of none."""
    path = to_fs_path(uri)
    return None if path is None or "\0" in path else Path(path).resolve()


class Heard:
    """What a client sends, without what no message is: it goes on with the next one that can be read.

    Args:
        stream: Standard input.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream

    def readline(self) -> bytes:
        """A line of a header; of what stands before the length of a message nothing."""
        line = self._stream.readline(MOST_LINE)
        if (length := _LENGTH.search(line)) is None:
            return line
        digits = length[1].lstrip(b"0") or b"0"
        fits = len(digits) <= len(str(MOST_BYTES)) and int(digits) <= MOST_BYTES
        return length[0] if fits else b"refused: larger than any message\r\n"

    def read(self, count: int) -> bytes:
        """The body of a message."""
        return self._stream.read(count)


def _is_error(diagnostic: lsp.Diagnostic) -> bool:
    return diagnostic.severity == lsp.DiagnosticSeverity.Error


def server() -> MissionServer:
    """A server with all that it answers."""
    made = MissionServer()

    @made.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    async def opened(ls: MissionServer, params: lsp.DidOpenTextDocumentParams) -> None:
        if (file := file_of(params.text_document.uri)) is not None:
            ls.tell(file)
            ls.explore(file)

    @made.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(ls: MissionServer, params: lsp.DidChangeTextDocumentParams) -> None:
        if (file := file_of(params.text_document.uri)) is not None:
            ls.tell_typed(file)

    @made.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    async def saved(ls: MissionServer, params: lsp.DidSaveTextDocumentParams) -> None:
        if (file := file_of(params.text_document.uri)) is not None:
            ls.problems = {}
            ls.tell(file)
            ls.explore(file)

    @made.feature(
        lsp.TEXT_DOCUMENT_COMPLETION,
        lsp.CompletionOptions(trigger_characters=["<", " ", '"', "'", "(", "=", "."]),
    )
    def completion(ls: MissionServer, params: lsp.CompletionParams) -> list[lsp.CompletionItem]:
        file = file_of(params.text_document.uri)
        return [] if file is None else ls.answers().completion(file, params.position)

    @made.feature(lsp.TEXT_DOCUMENT_HOVER)
    def hover(ls: MissionServer, params: lsp.HoverParams) -> lsp.Hover | None:
        file = file_of(params.text_document.uri)

        def known(name: str) -> str:
            return "\n\n".join(said for word, said in ls.names.items() if word.rpartition(".")[2] == name)

        return None if file is None else ls.answers().hover(file, params.position, known)

    @made.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(ls: MissionServer, params: lsp.DefinitionParams) -> list[lsp.Location]:
        file, answers = file_of(params.text_document.uri), ls.answers()
        found = [] if file is None else answers.meant(file, params.position)
        return [answers.place(symbol) for symbol in found if symbol.declares]

    @made.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    def references(ls: MissionServer, params: lsp.ReferenceParams) -> list[lsp.Location]:
        file, answers = file_of(params.text_document.uri), ls.answers()
        found = [] if file is None else answers.meant(file, params.position)
        declared = params.context.include_declaration
        return [answers.place(symbol) for symbol in found if declared or not symbol.declares]

    @made.feature(lsp.TEXT_DOCUMENT_RENAME)
    def rename(ls: MissionServer, params: lsp.RenameParams) -> lsp.WorkspaceEdit | None:
        file = file_of(params.text_document.uri)
        if file is None:
            return None
        try:
            return ls.answers().renamed(file, params.position, params.new_name)
        except ValueError as error:
            raise JsonRpcException(str(error), lsp.LSPErrorCodes.RequestFailed) from None

    @made.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def outlined(ls: MissionServer, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        file = file_of(params.text_document.uri)
        return [] if file is None else ls.answers().outline(file)

    @made.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    def formatting(ls: MissionServer, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        file = file_of(params.text_document.uri)
        return [] if file is None else ls.answers().formatted(file)

    @made.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix]))
    def mends(ls: MissionServer, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        file = file_of(params.text_document.uri)
        return [] if file is None else ls.answers().mends(file, params.range)

    return made
