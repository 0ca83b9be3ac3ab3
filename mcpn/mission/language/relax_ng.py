"""Makes the RELAX NG schema of the mission language from the classes of the model; declares nothing itself.

A new attribute of hardware, of an activity or of a fact is declared in :mod:`mcpn.mission.robot`, one of a
block in :mod:`mcpn.mission.model`, each as a field of its class. Then ``python docs/tables.py`` writes the
file ``schema.rng`` anew, by which mission files are validated, here and in editors.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from lxml import etree

from mcpn.mission.language.datatypes import Datatype
from mcpn.mission.language.forms import GROUPS, NAMESPACE, ROOTS, Field, Tag, as_read, form_of, language
from mcpn.mission.model import Import

_RNG = "{http://relaxng.org/ns/structure/1.0}"
_DOCUMENTATION = "{http://relaxng.org/ns/compatibility/annotations/1.0}documentation"
_HEAD = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- The mission language. What a schema cannot say (references, kinds, routing) is checked after it.
     In an editor: write this schema beside your files, and as the second line of each of them
     <?xml-model href="mission.rng" schematypens="http://relaxng.org/ns/structure/1.0"?>
     Rates are per hour, durations in hours. Made of the model by docs/tables.py: do not edit. -->
"""
_ROOT = f"""\
<grammar xmlns="http://relaxng.org/ns/structure/1.0" ns="{NAMESPACE}"
  xmlns:a="http://relaxng.org/ns/compatibility/annotations/1.0"
  datatypeLibrary="http://www.w3.org/2001/XMLSchema-datatypes"/>
"""


def relax_ng(*, core: bool = False) -> str:
    """The schema as the text of its file; or that of core missions, which is none."""
    tags = language(core=core)
    datatypes = {a.datatype.name: a.datatype for tag in tags.values() for a in tag.attributes.values()}
    groups = {
        group.TAG: [_attribute(a) for a in form_of(group).said(core=core) if a.owner is group]
        for group in GROUPS
    }
    root = etree.fromstring(_ROOT)
    root.append(_node("start", _any(root.TAG for root in ROOTS)))
    root.extend(_node("define", _data(datatype), name=f"data.{name}") for name, datatype in datatypes.items())
    root.extend(_node("define", *attributes, name=group) for group, attributes in groups.items())
    root.extend(_node("define", _element(name, tag, core=core), name=name) for name, tag in tags.items())
    etree.indent(root)  # what declares no more than an attribute is one line
    for node in root.iter():
        if next(node.iter(_RNG + "element"), None) is None and len([*node.iter(_DOCUMENTATION)]) < 2:
            for part in node.iter():
                part.text = None if len(part) else part.text
                part.tail = part.tail if part is node else None
    return _HEAD + etree.tostring(root, encoding="unicode") + "\n"


def _node(kind: str, *inside: etree._Element, **attributes: str) -> etree._Element:
    node = etree.Element(_RNG + kind, attributes)
    node.extend(inside)
    return node


def _note(words: str) -> etree._Element:
    note = etree.Element(_DOCUMENTATION)
    note.text = words
    return note


def _data(datatype: Datatype) -> etree._Element:
    if datatype.pattern is None:
        return _node("text")
    pattern = _node("param", name="pattern")
    pattern.text = datatype.pattern
    return _node("data", pattern, type="string")


def _attribute(field: Field) -> etree._Element:
    data = _node("ref", name=f"data.{field.datatype.name}")
    attribute = _node("attribute", _note(field.meaning), data, name=field.tag)
    return attribute if field.required else _node("optional", attribute)


def _element(name: str, tag: Tag, *, core: bool) -> etree._Element:
    variants = list(_variants(tag, core=core))
    shared = [a for a in tag.attributes.values() if all(a in said for said, _, _ in variants)]
    groups = dict.fromkeys(a.owner.TAG for a in shared if a.owner in GROUPS)
    attributes = [_attribute(a) for a in shared if a.owner not in GROUPS]
    frees = [free for _, free, _ in variants]
    one_way = core or len(frees) == 1  # of core missions no XML Schema is made
    common = [] if one_way else [child for child in frees[0] if all(child in free for free in frees)]
    ways = [
        [*(_attribute(a) for a in said if a not in shared), *_children(free, needed, common)]
        for said, free, needed in variants
    ]
    rest = ways[0] if len(ways) == 1 else [_node("choice", *(_node("group", *way) for way in ways))]
    if common:
        rest = [_node("zeroOrMore", _any(common)), *rest]
    return _node(
        "element",
        _note(tag.words),
        *(_node("ref", name=group) for group in groups),
        *attributes,
        *rest,
        name=name,
    )


def _variants(tag: Tag, *, core: bool) -> Iterator[tuple[list[Field], list[str], list[str]]]:
    """The ways to write an element: its attributes, what may stand inside, what must."""
    for element in tag.forms:
        said = [as_read(field, core=core) for field in form_of(element).said(core=core)]
        held = list(form_of(element).held(core=core))
        free = [Import.TAG] * (element in ROOTS)
        free += [child.TAG for each in held if not each.required for child in each.elements(core=core)]
        needed = [child.TAG for each in held if each.required for child in each.elements(core=core)]
        for content in held:
            if content.short:
                yield [*said, as_read(content.short, core=core)], free, []
        yield said, free, needed


def _children(free: list[str], needed: list[str], common: list[str]) -> Iterator[etree._Element]:
    """What may stand inside, and what must: after it, or mixed with it where elements are ``common``.

    Those are children of all ways to write an element and stand before the choice among these: what comes
    first then tells the way, as XML Schema asks ("Unique Particle Attribution").
    """
    if not common:
        yield from [_node("zeroOrMore", _any(free))] if free else []
        yield from [_node("oneOrMore", _any(needed))] if needed else []
        return
    own = [child for child in free if child not in common]
    assert not (own and needed), "what is mixed with what must stand inside is common"
    if needed:
        yield _any(needed)
        yield _node("zeroOrMore", _any([*free, *needed]))
    elif own:
        yield _node("optional", _node("group", _any(own), _node("zeroOrMore", _any(free))))


def _any(names: Iterable[str]) -> etree._Element:
    refs = [_node("ref", name=name) for name in dict.fromkeys(names)]
    return refs[0] if len(refs) == 1 else _node("choice", *refs)
