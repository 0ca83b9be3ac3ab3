"""The language of mission files as the model declares it: elements, their attributes and what stands inside.

The reader, the writer, the schema and its complaints, the renaming and the tables of the language use it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Container, Iterator
from dataclasses import MISSING, field
from functools import cache
from inspect import get_annotations
from types import UnionType
from typing import Any, NamedTuple, TypeAlias, TypeVar, Union, get_args, get_origin

from mcpn.mission.language.datatypes import (
    BY_CLASS,
    CORE_NAME,
    CORE_NAMES,
    CORE_OUTCOME,
    Called,
    Children,
    Core,
    Datatype,
)
from mcpn.mission.model import BlockElement, Import, Mission, Protocols
from mcpn.mission.robot import Described, Element, Robot
from mcpn.records import record

NAMESPACE = "urn:mcpn:mission:1"
ROOTS: tuple[_Element, ...] = (Mission, Robot, Protocols)
"""What may be the root of a file; each of them may hold imports."""
GROUPS: tuple[type[Described], ...] = (Described, Element, BlockElement)
"""Classes whose attributes several elements have."""
_Element: TypeAlias = type[Described]
_Note = TypeVar("_Note")


_IN_CORE = {datatype.name: datatype for datatype in (CORE_NAME, CORE_NAMES, CORE_OUTCOME)}


class Field(NamedTuple):
    """A field of a class of the model, and how files say it.

    Args:
        name: Its name in the model.
        classes: The classes of its value; where the value is a tuple, those of its members.
        several: Whether it is a tuple.
        default: Its value where none is given; ``MISSING`` where one must be.
        owner: The class that declares it.
        tag: The name of its attribute.
        type: What the attribute holds; ``None`` where the field is no attribute.
        words: What the attribute means.
        children: How the elements that are its members stand inside, where they are.
        core: Whether core missions alone say it.
    """

    name: str
    classes: tuple[type, ...]
    several: bool
    default: Any
    owner: type
    tag: str
    type: Datatype | None
    words: str
    children: Children
    core: bool

    @property
    def required(self) -> bool:
        """Whether it must be given."""
        return self.default is MISSING

    @property
    def datatype(self) -> Datatype:
        """What the attribute holds."""
        assert self.type is not None
        return self.type

    @property
    def meaning(self) -> str:
        """What the attribute means, and its default, where that is a value."""
        if self.default in (MISSING, None, ()):
            return self.words
        return f"{self.words} Default {self.datatype.write(self.default)}."

    @property
    def short(self) -> Field | None:
        """The attribute that may stand for a single member, if there is one."""
        if not self.children.short:
            return None
        (brief,) = (a for a in form_of(self.classes[0]).attributes if a.name == self.children.short)
        return brief._replace(words=self.children.words)

    def elements(self, *, core: bool = False) -> Iterator[_Element]:
        """The classes of the elements that files may hold for it, those of core missions or of others."""
        for member in self.classes:
            if issubclass(member, Described) and (core or member.TAG not in self.children.without):
                yield self.children.inside or member

    def in_core(self) -> Field:
        """The same in core missions, where names may be qualified, and facts choose more routes."""
        return self._replace(type=_IN_CORE.get(self.datatype.name, self.datatype))


class Form(NamedTuple):
    """A class of the model, as files say it.

    Args:
        fields: All of its fields, in the order of the model.
        attributes: Those that are attributes, as they are written: required ones first, the description last.
        contents: Those that stand inside, as they are written: required ones, such as blocks, last.
        core: Those of both that core missions alone have.
    """

    fields: tuple[Field, ...]
    attributes: tuple[Field, ...]
    contents: tuple[Field, ...]
    core: tuple[Field, ...]

    def said(self, *, core: bool = True) -> Iterator[Field]:
        """Its attributes, those of core missions among them or not."""
        yield from self.attributes
        yield from (field for field in self.core if core and field.type is not None)

    def held(self, *, core: bool = True) -> Iterator[Field]:
        """What stands inside, in core missions or not; blocks last."""
        yield from (field for field in self.core if core and field.type is None)
        yield from self.contents


_forms: dict[type, Form] = {}


def form_of(element: type) -> Form:
    """The form of a class of the model: how files write it. Computed once for each class."""
    if element not in _forms:
        owners = (base for base in reversed(element.__mro__) if "__dataclass_fields__" in vars(base))
        said = {f.name for f in dataclasses.fields(element) if f.init}
        known = {f.name: f for owner in owners for f in _declared(owner)}
        fields = tuple(field for name, field in known.items() if name in said)
        attributes = sorted(
            (f for f in fields if f.type and not f.core), key=lambda f: (f.owner is Described, not f.required)
        )
        contents = sorted(
            (f for f in fields if issubclass(f.classes[0], Described) and not f.core),
            key=lambda f: (f.required, f.owner is BlockElement),
        )
        core = tuple(f for f in fields if f.core)
        _forms[element] = Form(fields, tuple(attributes), tuple(contents), core)
    return _forms[element]


def _declared(owner: type) -> Iterator[Field]:
    hints = get_annotations(owner, eval_str=True)
    for declared in dataclasses.fields(owner):
        if declared.init and declared.name in hints:
            yield _field(owner, declared.name, declared.default, hints[declared.name])


def _field(owner: type, name: str, default: Any, hint: Any) -> Field:
    notes = getattr(hint, "__metadata__", ())
    hint = hint.__origin__ if notes else hint
    several = get_origin(hint) is tuple
    hint = get_args(hint)[0] if several else hint
    classes = get_args(hint) if get_origin(hint) in (UnionType, Union) else (hint,)

    def noted(kind: type[_Note]) -> _Note | None:
        return next((note for note in notes if isinstance(note, kind)), None)

    tag = (noted(Called) or Called(name)).name
    datatype = noted(Datatype) or BY_CLASS.get(classes[0])
    children, core = noted(Children) or Children(), noted(Core) is not None
    return Field(
        name=name,
        classes=classes,
        several=several,
        default=default,
        owner=owner,
        tag=tag,
        type=datatype,
        words=noted(str) or "",
        children=children,
        core=core,
    )


@record(frozen=True, slots=True)
class Tag:
    """What files may say in elements of one name.

    Args:
        forms: Classes they are read as: the first whose required attributes are there, or the last.
        attributes: By name.
        required: Names of attributes that are never left out.
        children: Names of elements that may stand inside.
    """

    forms: tuple[_Element, ...] = ()
    attributes: dict[str, Field] = field(default_factory=dict)
    required: frozenset[str] = frozenset()
    children: frozenset[str] = frozenset()

    @property
    def words(self) -> str:
        """What it means: what its classes say of themselves."""
        return " ".join(" ".join((form.__doc__ or "").split()) for form in self.forms)

    @property
    def series(self) -> bool:
        """Whether blocks must stand inside, after all else."""
        return len(self.forms) == 1 and any(
            c.required and not c.short for c in form_of(self.forms[0]).contents
        )

    def form(self, present: Container[str]) -> _Element:
        """The class that an element with some attributes is read as."""
        for form in self.forms[:-1]:
            if all(a.tag in present for a in form_of(form).attributes if a.required):
                return form
        return self.forms[-1]


def as_read(field: Field, *, core: bool) -> Field:
    """The field as files of a kind hold it: those of core missions, or those that people write."""
    return field.in_core() if core else field


def inside(element: type, *, core: bool = False) -> Iterator[_Element]:
    """The classes of the elements that may stand in one."""
    if element in ROOTS:
        yield Import
    for content in form_of(element).held(core=core):
        yield from content.elements(core=core)


@cache
def language(*, core: bool = False) -> dict[str, Tag]:
    """The elements of the language, by name; of that of core missions, or of the one that people write."""
    forms: dict[str, dict[_Element, None]] = {}
    stack = list(reversed(ROOTS))
    while stack:
        element = stack.pop()
        if element not in forms.setdefault(element.TAG, {}):
            forms[element.TAG][element] = None
            stack.extend(reversed(list(inside(element, core=core))))
    return {tag: _tag(tuple(classes), core=core) for tag, classes in forms.items()}


def _tag(classes: tuple[_Element, ...], *, core: bool) -> Tag:
    forms = [form_of(each) for each in classes]
    attributes = {a.tag: as_read(a, core=core) for form in forms for a in form.said(core=core)}
    shorts = [c.short for form in forms for c in form.contents if c.short]
    attributes |= {short.tag: as_read(short, core=core) for short in shorts}
    required = frozenset.intersection(*(frozenset(a.tag for a in f.attributes if a.required) for f in forms))
    children = frozenset(child.TAG for each in classes for child in inside(each, core=core))
    return Tag(classes, attributes, required, children)
