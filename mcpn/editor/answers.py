"""What an editor asks about a place in a mission: words, declarations, uses, other names, mends."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from pathlib import Path

from lsprotocol import types as lsp
from pygls.workspace import TextDocument

from mcpn.editor.layout import formatted
from mcpn.editor.outline import Outlined, outline
from mcpn.editor.project import Project
from mcpn.editor.route_targets import targets
from mcpn.editor.scan import ScannedAttribute, ScannedElement
from mcpn.editor.symbols import Symbol, attribute_of, resolved, scope_of, symbols, words
from mcpn.errors import Problem
from mcpn.mission.language.datatypes import BOOLEAN, NAME
from mcpn.mission.language.forms import ROOTS, Tag, language
from mcpn.mission.language.references import EXITS

_OPEN_VALUE = re.compile(r"(?<![\w.-])([A-Za-z_][\w.-]*)\s*=\s*(?:\"([^\"]*)|'([^']*))\Z")
"""An attribute whose value is not closed yet, and the value so far."""
_COLUMN = re.compile(r"(?:\b(\w++) of <(\w++)>: )?formula, column ([0-9]++)")
"""Where a formula is wrong, by a message: the attribute, if another than ``formula``, and the column."""
_ENTITY = re.compile(r"&[#\w]+;|.", re.DOTALL)

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
        return resolved([s for f in files for s in symbols(str(f), self.project.scan(f).elements)])

    def at(self, file: Path, position: lsp.Position) -> Symbol | None:
        """The name at a place."""
        offset = self.document(file).offset_at_position(position)
        here = (s for s in self.symbols(file) if Path(s.file) == file)
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

    def renamed(self, file: Path, position: lsp.Position, name: str) -> lsp.WorkspaceEdit:
        """The edits that give another name to what is named at a place.

        Raises:
            ValueError: There is no name, the new one is none or is taken, or the mission would not be valid
                with it; with a sentence that says so.
        """
        symbol = self.at(file, position)
        if symbol is None or symbol.kind == "value":
            raise ValueError("there is no name here that can be changed")
        if not NAME.matches(name) or (symbol.kind == "block" and name in EXITS):
            raise ValueError(f"{name} is no name: expected {NAME.expected}")
        every = self.symbols(file)
        meant = [s for s in every if symbol.means(s)]
        places = {(s.kind, s.scope) for s in meant if s.declares}
        if not places:
            raise ValueError(f"{symbol.name} is not declared in the files of this mission")
        if len(places) > 1:
            raise ValueError(f"several protocols have {symbol.name}: say here which one is meant")
        taken = next(
            (s for s in every if s.declares and s.name == name and (s.kind, s.scope) in places), None
        )
        if taken is not None and name != symbol.name:
            line = self.range(Path(taken.file), taken.begin, taken.end).start.line + 1
            raise ValueError(f"{name} is taken: see {Path(taken.file).name}, line {line}")
        self._tried(file, meant, name)
        edits: dict[str, list[lsp.TextEdit]] = {}
        for each in meant:
            at = self.place(each)
            edits.setdefault(at.uri, []).append(lsp.TextEdit(at.range, name))
        return lsp.WorkspaceEdit(changes=edits)

    def _tried(self, file: Path, meant: Iterable[Symbol], name: str) -> None:
        """Does without the new name if a mission that is valid would not be so with it."""
        if self.project.problems(file)[0]:
            return
        texts = dict(self.project.unsaved)
        for each in sorted(meant, key=lambda s: -s.begin):
            at = Path(each.file)
            text = texts.get(at) or self.project.text(at) or ""
            texts[at] = text[: each.begin] + name + text[each.end :]
        errors, _ = Project(texts).problems(file)
        if errors:
            raise ValueError(f"with the name {name} the mission is wrong: {errors[0].message}")

    def outline(self, file: Path) -> list[lsp.DocumentSymbol]:
        """The named elements of a file, each in that around it."""
        scan = self.project.scan(file)

        def shown(each: Outlined) -> lsp.DocumentSymbol:
            element = each.element
            name = next(a for a in element.attributes if a.name == "name" and a.value)
            return lsp.DocumentSymbol(
                name.value,
                _OUTLINE.get(element.tag, lsp.SymbolKind.Field),
                self.range(file, element.begin, each.end),
                self.range(file, name.begin, name.end),
                detail=element.tag,
                children=[shown(inner) for inner in each.inside],
            )

        return [shown(each) for each in outline(scan.text, scan.elements)]

    def formatted(self, file: Path) -> list[lsp.TextEdit]:
        """The edit that lays a file out; none where it is no XML, or is laid out already."""
        text = self.project.scan(file).text
        laid = formatted(text)
        return [] if laid in (None, text) else [lsp.TextEdit(self.range(file, 0, len(text)), laid or "")]

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
        return list(self._values(file, element, quoted[1], quoted[2] or quoted[3] or ""))

    def _values(
        self, file: Path, element: ScannedElement, attribute: str, before: str
    ) -> Iterator[lsp.CompletionItem]:
        field = attribute_of(element, attribute)
        if field is None or field.type is None:
            return
        kind = field.datatype.refers
        if kind == "block":
            elements = self.project.scan(file).elements
            for name in targets(element, attribute, elements):
                known = lsp.CompletionItemKind.Value if name in EXITS else lsp.CompletionItemKind.Reference
                yield _item(name, field.meaning, known)
            return
        for word in words(kind, before, scope_of(kind, element), self.symbols(file)):
            named = lsp.CompletionItemKind.Reference if word.names else lsp.CompletionItemKind.Keyword
            snippet = word.text + word.behind if word.behind else None
            yield _item(word.text, word.meaning, named, snippet)
        truths = ("true", "false") if field.type == BOOLEAN else ()
        choices = re.fullmatch(r"\\s\*\(([a-z_|]+)\)\\s\*", field.datatype.pattern or "")
        for text in truths or (choices[1].split("|") if choices else ()):
            yield _item(text, field.meaning, lsp.CompletionItemKind.Value)

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
        used = (s for s in every if not s.declares and s.kind != "value")
        return [s for s in used if (s.kind, s.name, s.scope) not in declared]

    def _of_problem(self, file: Path, problem: Problem, unknown: Iterable[Symbol]) -> lsp.Range:
        """The name that a problem speaks of in its line, else the start tag there, else the line."""
        scan, line = self.project.scan(file), (problem.source and problem.source.line) or 1
        begin = scan.lines[min(line, len(scan.lines)) - 1]
        end = scan.lines[line] if line < len(scan.lines) else len(scan.text)
        here = scan.between(begin, end)
        if (column := _COLUMN.search(problem.message)) is not None:
            for attribute in (a for e in here if column[2] in (None, e.tag) for a in e.attributes):
                if attribute.name == (column[1] or "formula"):
                    return self.range(file, *_at_column(attribute, int(column[3])))
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


_OUTLINE = {
    "mission": lsp.SymbolKind.Module,
    "robot": lsp.SymbolKind.Module,
    "protocols": lsp.SymbolKind.Module,
    "protocol": lsp.SymbolKind.Class,
    "objective": lsp.SymbolKind.Method,
    "parallel": lsp.SymbolKind.Method,
    "use": lsp.SymbolKind.Method,
    "each": lsp.SymbolKind.Method,
    "activity": lsp.SymbolKind.Function,
    "event": lsp.SymbolKind.Event,
    "fact": lsp.SymbolKind.Enum,
    "requirement": lsp.SymbolKind.Boolean,
    "parameter": lsp.SymbolKind.Constant,
}
"""Symbols that editors show for elements; fields for others."""


def _at_column(attribute: ScannedAttribute, column: int) -> tuple[int, int]:
    """The word in the column of a formula, which counts what XML writes as ``&gt;`` as one character."""
    places = [found.start() for found in _ENTITY.finditer(attribute.value)]
    begin = places[column - 1] if column <= len(places) else len(attribute.value)
    word = re.compile(r"[\w.]+|\S|").match(attribute.value, begin)
    end = begin + len(word[0]) if word else begin
    if end == begin:  # what is missing at the end is shown at the last character
        begin = max(begin - 1, 0)
    return attribute.begin + begin, attribute.begin + end


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
