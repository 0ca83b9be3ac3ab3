"""What an editor asks about a place in a mission: words, declarations, uses, other names, mends."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from pathlib import Path

from lsprotocol import types as lsp
from pygls.workspace import TextDocument

from mcpn.editor.project import Project
from mcpn.editor.scan import ScannedElement
from mcpn.editor.symbols import EXITS, Symbol, attribute_of, scope_of, symbols
from mcpn.errors import Problem
from mcpn.mission.language.datatypes import BOOLEAN, NAME
from mcpn.mission.language.forms import ROOTS, Tag, language

_OPEN_VALUE = re.compile(r"(?<![\w.-])([A-Za-z_][\w.-]*)\s*=\s*[\"'][^\"']*\Z")
"""An attribute whose value is not closed yet."""

SOURCE = "mcpn"
Findings = Callable[[str], str]
"""What is known of an objective or a resource by name, as Markdown; empty where nothing is."""


class Answers:
    """Answers about the files of a project.

    Args:
        project: The files.
        document: A file as a document of the protocol, which knows its positions.
    """

    def __init__(self, project: Project, document: Callable[[Path], TextDocument]) -> None:
        self.project = project
        self.document = document

    def symbols(self, file: Path) -> list[Symbol]:
        """The names in all files that name the same things as a file."""
        files = self.project.together(file)
        return [symbol for f in files for symbol in symbols(str(f), self.project.scan(f).elements)]

    def at(self, file: Path, position: lsp.Position) -> Symbol | None:
        """The name at a place."""
        offset = self.document(file).offset_at_position(position)
        here = symbols(str(file), self.project.scan(file).elements)
        return next((s for s in here if s.begin <= offset <= s.end), None)

    def meant(self, file: Path, position: lsp.Position) -> list[Symbol]:
        """Every place that names what is named at a place, declarations first."""
        symbol = self.at(file, position)
        found = [s for s in self.symbols(file) if symbol and symbol.means(s)]
        return sorted(found, key=lambda s: not s.declares)

    def place(self, symbol: Symbol) -> lsp.Location:
        """Where a name stands."""
        return lsp.Location(
            Path(symbol.file).as_uri(), self.range(Path(symbol.file), symbol.begin, symbol.end)
        )

    def range(self, file: Path, begin: int, end: int) -> lsp.Range:
        """A range of characters of a file."""
        scan, codec = self.project.scan(file), self.document(file).position_codec

        def position(offset: int) -> lsp.Position:
            line = bisect_right(scan.lines, offset) - 1
            return lsp.Position(line, codec.client_num_units(scan.text[scan.lines[line] : offset]))

        return lsp.Range(position(begin), position(end))

    def renamed(self, file: Path, position: lsp.Position, name: str) -> lsp.WorkspaceEdit | None:
        """The edits that give another name to what is named at a place; ``None`` where that is no name."""
        if not NAME.matches(name) or name in EXITS:
            return None
        edits: dict[str, list[lsp.TextEdit]] = {}
        for symbol in self.meant(file, position):
            at = self.place(symbol)
            edits.setdefault(at.uri, []).append(lsp.TextEdit(at.range, name))
        return lsp.WorkspaceEdit(changes=edits) if edits else None

    # --- words ---

    def hover(self, file: Path, position: lsp.Position, known: Findings) -> lsp.Hover | None:
        """What the language says of what stands at a place, and what is known of what it names."""
        offset = self.document(file).offset_at_position(position)
        elements = self.project.scan(file).elements
        element = next((e for e in reversed(elements) if e.begin <= offset < e.end), None)
        if element is None or element.tag not in language():
            return None
        said = [f"**{element.tag}**: {language()[element.tag].words}"]
        for attribute in element.attributes:
            field = attribute_of(element, attribute.name)
            if field and attribute.begin - len(attribute.name) - 2 <= offset <= attribute.end:
                said = [f"**{attribute.name}**: {field.meaning}"]
        if (symbol := self.at(file, position)) is not None:
            declared = next((s for s in self.symbols(file) if s.declares and s.means(symbol)), None)
            if declared and (description := declared.element.texts.get("description")):
                said.append(description)
            said.append(known(symbol.name))
        return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, "\n\n".join(filter(None, said))))

    def completion(self, file: Path, position: lsp.Position) -> list[lsp.CompletionItem]:
        """What may stand at a place: elements, attributes, names and values."""
        scan, offset = self.project.scan(file), self.document(file).offset_at_position(position)
        text, element = scan.text, scan.open_at(offset)
        if element is None or element.begin + 1 + len(element.tag) >= offset:
            around = scan.around(element.begin if element else offset)
            roots = frozenset(root.TAG for root in ROOTS)
            tags = language().get(around.tag, Tag()).children if around else roots
            return [_item(tag, language()[tag].words, lsp.CompletionItemKind.Class) for tag in sorted(tags)]
        quoted = _OPEN_VALUE.search(text[element.begin : offset])
        if quoted is None:
            known = language().get(element.tag)
            fields = known.attributes if known else {}
            return [
                _item(name, field.meaning, lsp.CompletionItemKind.Property, f'{name}="$1"')
                for name, field in fields.items()
                if name not in element.texts
            ]
        return list(self._values(file, element, quoted[1]))

    def _values(self, file: Path, element: ScannedElement, attribute: str) -> Iterator[lsp.CompletionItem]:
        field = attribute_of(element, attribute)
        if field is None or field.type is None:
            return
        kind = field.datatype.refers
        scope = scope_of(kind, element)
        declared = (s for s in self.symbols(file) if s.declares and (s.kind, s.scope) == (kind, scope))
        for symbol in {s.name: s for s in declared}.values():
            description = symbol.element.texts.get("description", "")
            yield _item(symbol.name, description, lsp.CompletionItemKind.Reference)
        words = EXITS if kind == "block" else ("true", "false") if field.type == BOOLEAN else ()
        choices = re.fullmatch(r"\\s\*\(([a-z_|]+)\)\\s\*", field.datatype.pattern or "")
        for word in words or (choices[1].split("|") if choices else ()):
            yield _item(word, field.meaning, lsp.CompletionItemKind.Value)

    # --- problems ---

    def diagnostics(self, file: Path, *, at_once: bool = False) -> dict[Path, list[lsp.Diagnostic]]:
        """The problems of the missions that a file is part of, by file.

        Args:
            file: The file.
            at_once: Whether what was suspicious before is told, where nothing is wrong.
        """
        found: dict[Path, list[lsp.Diagnostic]] = {f: [] for f in self.project.together(file)}
        errors, warnings = self.project.problems(file, at_once=at_once)
        unknown = self.unknown(file) if errors else []
        for severity, problems in (
            (lsp.DiagnosticSeverity.Error, errors),
            (lsp.DiagnosticSeverity.Warning, warnings),
        ):
            for problem in problems:
                at = Path(problem.source.file).resolve() if problem.source else file
                range_ = self._of_problem(at, problem, unknown)
                found.setdefault(at, []).append(
                    lsp.Diagnostic(range_, problem.message, severity=severity, source=SOURCE)
                )
        return found

    def unknown(self, file: Path) -> list[Symbol]:
        """The names that nothing has, in all files that name the same things as a file."""
        every = self.symbols(file)
        declared = {(s.kind, s.name, scope) for s in every if s.declares for scope in (s.scope, None)}
        return [s for s in every if not s.declares and (s.kind, s.name, s.scope) not in declared]

    def _of_problem(self, file: Path, problem: Problem, unknown: Iterable[Symbol]) -> lsp.Range:
        """The name that a problem speaks of in its line, else the start tag there, else the line."""
        scan, line = self.project.scan(file), (problem.source and problem.source.line) or 1
        begin = scan.lines[min(line, len(scan.lines)) - 1]
        end = scan.lines[line] if line < len(scan.lines) else len(scan.text)
        here = scan.between(begin, end)
        words = set(re.findall(r"[\w.]+", problem.message))
        for symbol in unknown:
            if Path(symbol.file) == file and begin <= symbol.begin < end and symbol.name in words:
                return self.range(file, symbol.begin, symbol.end)
        for element in here:
            for attribute in element.attributes:
                for word in re.finditer(r"[\w.]+", attribute.value):
                    if word[0] in words and begin <= attribute.begin + word.start() < end:
                        start = attribute.begin + word.start()
                        return self.range(file, start, start + len(word[0]))
        if here:
            return self.range(file, here[-1].begin, here[-1].end)
        return self.range(file, begin, max(begin, end - 1))

    def mends(self, file: Path, range_: lsp.Range) -> list[lsp.CodeAction]:
        """Near names for those in a range that nothing has."""
        declared = [s for s in self.symbols(file) if s.declares]
        first, last = (self.document(file).offset_at_position(p) for p in (range_.start, range_.end))
        found = []
        for symbol in self.unknown(file):
            if Path(symbol.file) != file or symbol.begin > last or symbol.end < first:
                continue
            known = {d.name for d in declared if d.kind == symbol.kind and symbol.scope in (d.scope, None)}
            for near in get_close_matches(symbol.name, _with_exits(symbol.kind, known), n=3):
                edit = lsp.TextEdit(self.range(file, symbol.begin, symbol.end), near)
                found.append(
                    lsp.CodeAction(
                        f"Change {symbol.name} to {near}",
                        kind=lsp.CodeActionKind.QuickFix,
                        edit=lsp.WorkspaceEdit(changes={file.as_uri(): [edit]}),
                    )
                )
        return found


def _with_exits(kind: str, known: Iterable[str]) -> list[str]:
    return sorted({*known, *(EXITS if kind == "block" else ())})


def _item(
    label: str, words: str, kind: lsp.CompletionItemKind, snippet: str | None = None
) -> lsp.CompletionItem:
    return lsp.CompletionItem(
        label,
        kind=kind,
        documentation=words or None,
        insert_text=snippet,
        insert_text_format=lsp.InsertTextFormat.Snippet if snippet else None,
    )
