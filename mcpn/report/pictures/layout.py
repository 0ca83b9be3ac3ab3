"""Where the parts of a mission's picture stand: a layout of its own, for boxes in boxes.

Blocks of a series stand below each other, branches of a parallel block side by side. Routes run in lanes
beside a series: failures on the left, all else on the right, one lane for each target. Success that leads to
the next block is an arrow between the two. A route with a label has a line of its own beside the block that
it leaves: the label stands behind all lanes, where nothing else is drawn.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from mcpn.mission.model import ABORT, FAIL, SUCCEED, Mission
from mcpn.mission.robot import Hardware
from mcpn.report.pictures.boxes import Box, facts_said

PAD, LANE, GAP, ROW, HEAD, EXIT, LINE = 12, 14, 28, 19, 24, 22, 15
MOST_CHARACTERS, MOST_LABEL = 48, 24
ROBOT_WIDTH = 860
LABELLED = ("event", "abort")
"""Kinds of lanes that have a label."""
BOLD = 16.5
"""Size of a plain text that is as wide as a name, which is bold."""


@dataclass(frozen=True)
class Rectangle:
    """A rectangle with what it stands for.

    Args:
        x: Left.
        y: Top.
        width: Width.
        height: Height.
        kind: Its class in the picture.
        title: The text for a pointer that rests on it, or a screen reader.
        data: What a script finds it by.
    """

    x: float
    y: float
    width: float
    height: float
    kind: str
    title: str = ""
    data: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Label:
    """A line of text; its place is where it begins, on the baseline."""

    x: float
    y: float
    text: str
    kind: str
    data: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Line:
    """A route: corners from its beginning on, with an arrow at its end or none."""

    points: tuple[tuple[float, float], ...]
    kind: str
    arrow: bool
    title: str = ""


@dataclass
class Picture:
    """A picture's parts, back to front."""

    width: float = 0
    height: float = 0
    frames: list[Rectangle] = field(default_factory=list)
    lines: list[Line] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)


@dataclass(frozen=True)
class _Lanes:
    """Lanes beside a series: by side, (kind, label, target) in order, the innermost first."""

    left: tuple[tuple[str, str, str], ...]
    right: tuple[tuple[str, str, str], ...]

    @property
    def left_width(self) -> float:
        return LANE * (len(self.left) + 1)

    @property
    def right_width(self) -> float:
        widths = [
            text_width(shown(label, MOST_LABEL), 11.5) for kind, label, _ in self.right if kind in LABELLED
        ]
        return LANE * (len(self.right) + 1) + max(widths, default=0)


def shown(text: str, most: int = MOST_CHARACTERS) -> str:
    """A text that fits: cut where it is too long, characters that XML forbids replaced."""
    legal = "".join(c if _legal(c) else "\ufffd" for c in text)
    return legal if len(legal) <= most else legal[: most - 1] + "…"


def _legal(character: str) -> bool:
    code = ord(character)
    if code < 0x20:
        return character in "\t\n"
    return not (0x7F <= code < 0xA0 or 0xD800 <= code <= 0xDFFF or code in (0xFFFE, 0xFFFF))


def text_width(text: str, size: float = 13) -> float:
    """About as wide as a text is drawn."""
    wide = sum(unicodedata.east_asian_width(c) in "WF" for c in text)
    return size * (0.58 * (len(text) - wide) + 1.05 * wide)


def lay_out(root: Box, mission: Mission) -> Picture:
    """The picture of a mission: its blocks, and below them its robots' activities and hardware."""
    layout = _Layout()
    width, height = layout.size(root)
    layout.place(root, PAD, PAD)
    picture = layout.picture
    picture.width, picture.height = width + 2 * PAD, height + 2 * PAD
    _robot(picture, mission, max(width, ROBOT_WIDTH))
    return picture


class _Layout:
    def __init__(self) -> None:
        self.picture = Picture()
        self._sizes: dict[int, tuple[float, float]] = {}
        self._lanes: dict[int, _Lanes] = {}

    def size(self, box: Box) -> tuple[float, float]:
        if box.key not in self._sizes:
            self._sizes[box.key] = self._size(box)
        return self._sizes[box.key]

    def _size(self, box: Box) -> tuple[float, float]:
        texts = [(shown(box.name), BOLD), *((shown(note), 11.5) for note in box.notes)]
        texts += [(shown(activity), 13.0) for activity in box.activities]
        width = max(130.0, *(text_width(text, size) + 2 * PAD for text, size in texts))
        head = HEAD + ROW * len(box.notes)
        if box.kind == "objective":
            return width, head + ROW * len(box.activities) + PAD / 2
        sizes = [self.size(child) for child in box.children]
        if box.kind == "parallel":
            inside = sum(w for w, _ in sizes) + PAD * (len(sizes) - 1)
            return max(width, inside + 2 * PAD), head + max(h for _, h in sizes) + PAD
        lanes = self._lanes[box.key] = _lanes(box)
        inside = max(w for w, _ in sizes) + lanes.left_width + lanes.right_width
        slots = sum(max(h, _slot(lines)) for (_, h), lines in zip(sizes, _labelled(box), strict=True))
        height = slots + GAP * len(sizes) + len(_exits(box)) * EXIT + LINE * len(_own_events(box))
        return max(width, inside + 2 * PAD), head + height + PAD

    def place(self, box: Box, x: float, y: float) -> None:
        width, height = self.size(box)
        kind = f"block {box.kind}" + ("" if box.mandatory else " optional")
        title = f"{box.kind} {box.name}" + (f": {box.description}" if box.description else "")
        data = (("box", str(box.key)),) if box.kind == "objective" else ()
        self.picture.frames.append(Rectangle(x, y, width, height, kind, shown(title, 1000), data))
        labels = self.picture.labels
        labels.append(Label(x + PAD, y + 17, shown(box.name), "name"))
        below = y + 17
        for note in box.notes:
            below += ROW
            labels.append(Label(x + PAD, below, shown(note), "note"))
        for activity in box.activities:
            below += ROW
            within = (("box", str(box.key)), ("within", activity))
            labels.append(Label(x + PAD, below, shown(activity), "activity", within))
        top = y + HEAD + ROW * len(box.notes)
        if box.kind == "parallel":
            at = x + PAD
            for child in box.children:
                self.place(child, at, top)
                at += self.size(child)[0] + PAD
        elif box.children:
            self._series(box, x, top, width)

    def _series(self, box: Box, x: float, top: float, width: float) -> None:
        """Places the children of a series and its routes."""
        lanes = self._lanes[box.key]
        middle = x + lanes.left_width + (width - lanes.left_width - lanes.right_width) / 2
        inner = max(self.size(child)[0] for child in box.children)
        y = top + GAP / 2 + LINE * len(_own_events(box))
        spots: dict[str, tuple[float, float, float]] = {}
        ends: dict[str, float] = {}
        lines: dict[tuple[str, str, str], float] = {}
        """By lane with a label, the height of its line."""
        for number, lane in enumerate(_own_events(box)):
            lines.setdefault(lane, top + LINE * (number + 1))
        for child, labelled in zip(box.children, _labelled(box), strict=True):
            w, h = self.size(child)
            self.place(child, middle - w / 2, y)
            spots[child.name] = (middle - w / 2, middle + w / 2, y + 10)
            ends[child.name] = y + h
            slot = max(h, _slot(labelled))
            for number, lane in enumerate(labelled):
                lines[lane] = y + slot - 8 - LINE * (len(labelled) - 1 - number)
            y += slot + GAP
        for exit_name, word in _exits(box).items():
            half = text_width(word) / 2 + 10
            spots[exit_name] = (middle - half, middle + half, y - GAP / 2 + EXIT / 2)
            self.picture.frames.append(
                Rectangle(
                    middle - half, y - GAP / 2, 2 * half, EXIT - 4, f"exit {word}", f"{word} of {box.name}"
                )
            )
            mark = {"success": "✓", "failure": "✗", "abort": "⚠"}[word]
            self.picture.labels.append(
                Label(middle - half + 6, y - GAP / 2 + 13.5, f"{mark} {word}", f"end {word}")
            )
            y += EXIT
        self._straight(box, spots, ends, middle)
        edges = (middle - inner / 2, middle + inner / 2)
        self._routes(box, spots, ends, edges, lines)

    def _straight(
        self,
        box: Box,
        spots: dict[str, tuple[float, float, float]],
        ends: dict[str, float],
        middle: float,
    ) -> None:
        """Arrows of success to what stands next."""
        for index, child in enumerate(box.children):
            if _success(box, index) == _next(box, index):
                target = spots[_next(box, index)][2] - (10 if index + 1 < len(box.children) else EXIT / 2)
                points = ((middle, ends[child.name]), (middle, target))
                self.picture.lines.append(Line(points, "success", True, f"{child.name} succeeds"))

    def _routes(
        self,
        box: Box,
        spots: dict[str, tuple[float, float, float]],
        ends: dict[str, float],
        edges: tuple[float, float],
        lines: dict[tuple[str, str, str], float],
    ) -> None:
        """Routes in the lanes: from each source a stub to the lane, from the lane an arrow to the target."""
        lanes = self._lanes[box.key]
        behind = edges[1] + LANE * (len(lanes.right) + 0.6)
        using: dict[tuple[str, str, str], list[Box]] = {}
        for index, child in enumerate(box.children):
            for lane in dict.fromkeys(_of_child(box, index)):
                using.setdefault(lane, []).append(child)
        for side, all_lanes in enumerate((lanes.left, lanes.right)):
            for number, lane in enumerate(all_lanes, 1):
                kind, label, target = lane
                at = edges[side] + LANE * number * (1 if side else -1)
                heights = [spots[target][2]]
                first = lines.get(lane)
                for child in using.get(lane, ()):
                    y = ends[child.name] - 8 - (5 * (number % 4) if side else 0)
                    if first is not None and lane not in _own_events(box) and child is using[lane][0]:
                        y = first
                    heights.append(y)
                    title = f"{child.name}: {label} leads to {target}"
                    stub = ((min(spots[child.name][1], at) if side else spots[child.name][0], y), (at, y))
                    self.picture.lines.append(Line(stub, kind, False, title))
                if first is not None:
                    heights.append(first)
                    leads = ((at, first), (behind - 2, first))
                    self.picture.lines.append(Line(leads, "leader", False, label))
                    self.picture.labels.append(
                        Label(behind, first + 4, shown(label, MOST_LABEL), f"note route-label {kind}")
                    )
                self.picture.lines.append(
                    Line(((at, min(heights)), (at, max(heights))), kind, False, f"{label} leads to {target}")
                )
                into = ((at, spots[target][2]), (spots[target][side], spots[target][2]))
                self.picture.lines.append(Line(into, kind, True, f"{label} leads to {target}"))


def _next(box: Box, index: int) -> str:
    return box.children[index + 1].name if index + 1 < len(box.children) else SUCCEED


def _success(box: Box, index: int) -> str | None:
    return box.children[index].success or box.children[index].after


def _of_child(box: Box, index: int) -> list[tuple[str, str, str]]:
    """The lanes that a child's routes use."""
    child = box.children[index]
    routes = [("failure", "failure", child.failure or FAIL)]
    if (success := _success(box, index)) is not None and success != _next(box, index):
        routes.append(("success", "success", success))
    if child.abort is not None:
        routes.append(("abort", "abort", child.abort))
    if child.recover is not None:
        routes.append(("event", "recover", child.recover))
    if child.timeout_goto is not None:
        routes.append(("event", "timeout", child.timeout_goto))
    routes += [("event", said, route.goto) for route, said in facts_said(child.routes)]
    return [*routes, *_on_events(child)]


def _exits(box: Box) -> dict[str, str]:
    """The exits of a series that are drawn: abort where something in it says so."""
    exits = {SUCCEED: "success", FAIL: "failure"}
    lanes = [*_own_events(box), *(lane for i in range(len(box.children)) for lane in _of_child(box, i))]
    targets = [*(target for *_, target in lanes), *(child.success for child in box.children)]
    return {**exits, ABORT: "abort"} if ABORT in targets else exits


def _own_events(box: Box) -> list[tuple[str, str, str]]:
    if box.kind != "mission":
        return []
    return _on_events(box)


def _on_events(box: Box) -> list[tuple[str, str, str]]:
    """The lanes of what a box does on events."""
    lanes = list[tuple[str, str, str]]()
    for handler in box.handlers:
        said = f"{'pauses on' if handler.pause else 'on'} {handler.event or ' '.join(handler.when)}"
        said += " once" if handler.once else ""
        lanes += (("event", f"{said} when {' '.join(each.when)}", each.goto) for each in handler.routes)
        lanes.append(("event", said, handler.pause or handler.goto or ABORT))
    return lanes


def _labelled(box: Box) -> list[list[tuple[str, str, str]]]:
    """For each child the lanes whose labels stand beside it: those that no child before it uses."""
    seen, found = dict.fromkeys(_own_events(box)), []
    for index in range(len(box.children)):
        new = [
            each for each in dict.fromkeys(_of_child(box, index)) if each[0] in LABELLED and each not in seen
        ]
        seen |= dict.fromkeys(new)
        found.append(new)
    return found


def _slot(labelled: Sequence[object]) -> float:
    """The height that the labels beside a block need."""
    return 12 + LINE * len(labelled) if labelled else 0


def _lanes(box: Box) -> _Lanes:
    every = [lane for i in range(len(box.children)) for lane in _of_child(box, i)]
    lanes = list(dict.fromkeys([*every, *_own_events(box)]))
    left = tuple(lane for lane in lanes if lane[0] == "failure")
    return _Lanes(left, tuple(lane for lane in lanes if lane[0] != "failure"))


_Data: TypeAlias = tuple[tuple[str, str], ...]
_Cell: TypeAlias = tuple[str, list[tuple[str, _Data]], Rectangle]
"""A name, lines of text with what a script finds them by, and a frame that has no place yet."""


def _robot(picture: Picture, mission: Mission, width: float) -> None:
    """Adds what the robots can do and have, in rows."""
    y = picture.height + PAD
    cells: list[_Cell] = []
    for activity in (a for robot in mission.robots for a in robot.activities):
        rows: list[tuple[str, _Data]] = []
        for number, way in enumerate(activity.alternatives, 1):
            needs = " + ".join(way.consumes) or "nothing"
            data: _Data = (("activity", activity.name), ("alternative", way.name))
            crashes = ", may crash" if way.faulty else ""
            asked = f", if {' '.join(way.requires)}" if way.requires else ""
            rows.append((shown(f"{number}. {way.name}: {needs}{asked}{crashes}"), data))
        if activity.requires:
            rows.append((shown(f"if {' '.join(activity.requires)}"), ()))
        if activity.faulty:
            rows.append(("may crash", ()))
        if activity.produces:
            rows.append((shown(f"gives {' + '.join(activity.produces)}"), ()))
        title = f"activity {activity.name}" + (f": {activity.description}" if activity.description else "")
        frame = Rectangle(0, 0, 0, 0, "block robot", shown(title, 1000), (("activity", activity.name),))
        cells.append((activity.name, rows, frame))
    y = _rows(picture, "Activities and their alternatives", cells, width, y)
    cells = []
    for hardware in (h for robot in mission.robots for h in robot.hardware):
        rows = [(text, ()) for text in _fails(hardware)]
        rows += [(shown(f"fails with {f.name}"), ()) for f in mission.faults if hardware.name in f.affects]
        title = f"hardware {hardware.name}" + (f": {hardware.description}" if hardware.description else "")
        frame = Rectangle(0, 0, 0, 0, "block hardware", shown(title, 1000), (("hardware", hardware.name),))
        cells.append((hardware.name, rows, frame))
    y = _rows(picture, "Hardware", cells, width, y)
    cells = []
    for fact in mission.facts:
        rows = [(shown(f"{' or '.join(fact.values)}, at first {fact.start}"), ())]
        setting = [e.name for e in mission.events if fact.name in e.changed_facts]
        rows += [(shown(f"set by {' '.join(setting)}"), ())] if setting else []
        title = f"fact {fact.name}" + (f": {fact.description}" if fact.description else "")
        cells.append((fact.name, rows, Rectangle(0, 0, 0, 0, "block robot", shown(title, 1000))))
    picture.height = _rows(picture, "Facts", cells, width, y)


def _fails(hardware: Hardware) -> Iterator[str]:
    """Whether hardware may fail, and what becomes of it then."""
    if not hardware.faulty:
        yield "never fails"
    else:
        yield "may fail" if hardware.repairable else "may fail, and is not repaired"
    if hardware.initial == "oos":
        yield "out of service at the start"
    if hardware.detected == "late":
        yield "its loss is noticed late"


def _rows(
    picture: Picture,
    heading: str,
    cells: Sequence[_Cell],
    width: float,
    y: float,
) -> float:
    """Places cells in rows under a heading.

    Returns:
        Where the next thing may stand.
    """
    if not cells:
        return y
    picture.labels.append(Label(PAD, y + 12, heading, "heading"))
    picture.width = max(picture.width, text_width(heading, BOLD) + 2 * PAD)
    y += 22
    x, highest = float(PAD), 0.0
    for name, rows, frame in cells:
        widths = [text_width(shown(name), BOLD), *(text_width(text, 12) for text, _ in rows)]
        w, h = max(widths) + 2 * PAD, HEAD + ROW * len(rows) + PAD / 2
        if x > PAD and x + w > width + PAD:
            x, y, highest = float(PAD), y + highest + PAD, 0.0
        picture.frames.append(Rectangle(x, y, w, h, frame.kind, frame.title, frame.data))
        picture.labels.append(Label(x + PAD, y + 17, shown(name), "name"))
        for number, (text, data) in enumerate(rows, 1):
            picture.labels.append(
                Label(x + PAD, y + 17 + ROW * number, text, "way" if data else "note", data)
            )
        picture.width = max(picture.width, x + w + PAD)
        x, highest = x + w + PAD, max(highest, h)
    return y + highest + 2 * PAD
