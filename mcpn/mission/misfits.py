"""Validates mission files against the schema, with errors that say what was found and expected.

libxml2 decides, by the file ``schema.rng``, which :mod:`mcpn.mission.language.forms` makes. It says little
of why a document fails, so elements and attributes are compared with the language once more to find that.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import get_args

from lxml import etree

from mcpn.did_you_mean import did_you_mean
from mcpn.mission.language.forms import NAMESPACE, ROOTS, Tag, form_of, language
from mcpn.mission.language.relax_ng import relax_ng
from mcpn.mission.model import Block, Recursive
from mcpn.sentences import enumeration, quoted
from mcpn.xmlio import line_of

_BLOCKS = tuple(dict.fromkeys(block.TAG for block in get_args(Block)))
_UNKNOWN = Tag()
LOCATION = "{http://www.w3.org/2001/XMLSchema-instance}schemaLocation"
"""Where an XML Schema is: any root element may have it by that standard; here it has no meaning.

The schema does not say so: trang would declare it in the XSD, which Xerces then refuses.
"""
SCHEMA = Path(__file__).with_name("schema.rng")


@cache
def _validator(*, core: bool) -> etree.RelaxNG:
    if core:
        return etree.RelaxNG(etree.fromstring(relax_ng(core=True).encode()))
    with SCHEMA.open("rb") as file:
        return etree.RelaxNG(etree.parse(file))


def find_misfits(
    root: etree._Element, new: tuple[etree._Element, Iterable[etree._Element]] | None = None
) -> list[tuple[int, str]]:
    """What in a document does not fit the schema.

    Args:
        root: The root element of a mission, robot or protocols file.
        new: After an edit of a document that fitted: an excerpt (if it fits the schema, so does the whole),
            and the elements that may not fit, by themselves or in what they hold.

    Returns:
        Lines and messages; empty where the document is valid.
    """
    name = etree.QName(root)
    if name.namespace != NAMESPACE or name.localname not in {root.TAG for root in ROOTS}:
        return [(line_of(root), _no_root(name))]
    root.attrib.pop(LOCATION, "")
    core = is_core(root)
    validator = _validator(core=core)
    excerpt, suspects = new or (root, root.iter())
    if validator.validate(excerpt):
        return []
    misfits = list(_misfits(suspects, core=core))
    if misfits:
        return misfits
    if new and validator.validate(root):
        return []
    return [(line_of(element), _contents(element)) for element in _blamed(root, validator)[:1]] or [
        (line_of(root), "does not fit the mission language")
    ]


def _blamed(root: etree._Element, validator: etree.RelaxNG) -> list[etree._Element]:
    """The elements of a document at which libxml2 says that it does not fit, in document order."""
    # Its path to an element has names as they are written, and * where a name has no prefix but a namespace.
    paths = (re.sub(r"(?<=/)[^/*\[]+", r'*[name()="\g<0>"]', e.path) for e in validator.error_log if e.path)
    found = root.getroottree().xpath(" | ".join(dict.fromkeys(paths)) or "/*")
    assert isinstance(found, list), "an expression of elements"
    return [element for element in found if isinstance(element, etree._Element)]


def _no_root(name: etree.QName) -> str:
    """What is wrong with a root element that begins no file of a mission."""
    if name.localname in {root.TAG for root in ROOTS}:
        found = f"in the namespace {name.namespace}" if name.namespace else "without a namespace"
        return f'found <{name.localname}> {found}, expected <{name.localname} xmlns="{NAMESPACE}" ...>'
    return f"found the root element {name.text}, expected a mission file (namespace {NAMESPACE})"


def is_core(root: etree._Element) -> bool:
    """Whether a file says that it is a core mission, which nobody writes by hand."""
    return root.get("core") == "true"


def _misfits(among: Iterable[etree._Element], *, core: bool) -> Iterator[tuple[int, str]]:
    tags = language(core=core)
    for element in among:
        tag, line = etree.QName(element).localname, line_of(element)
        parent = element.getparent()
        yield from _misplaced(element, core=core)
        if parent is not None:
            outer = etree.QName(parent).localname
            allowed = tags[outer].children if outer in tags else (tag,)
            if tag not in allowed or etree.QName(element).namespace != NAMESPACE:
                expected = ", ".join(f"<{name}>" for name in sorted(allowed)) or "nothing"
                yield line, f"found <{tag}> inside <{outer}>, expected {expected}{did_you_mean(tag, allowed)}"
                continue
        rule = tags.get(tag, _UNKNOWN)
        for name, value in ((str(key), str(text)) for key, text in element.attrib.items()):
            if name not in rule.attributes:
                known = sorted(rule.attributes)
                found = f"found the attribute {name} on <{tag}>, expected one of {', '.join(known)}"
                holders = enumeration([f"<{other}>" for other, of in tags.items() if name in of.attributes])
                elsewhere = f"; {name} is of {holders}" if holders else ""
                yield line, f"{found}{did_you_mean(name, known) or elsewhere}"
            elif not (datatype := rule.attributes[name].datatype).matches(value):
                yield line, f"{name} of <{tag}> is {quoted(value)}, expected {datatype.expected}"
        for name in sorted(rule.required - set(element.attrib)):
            yield line, f"<{tag}> has no attribute {name}, which is required"


def _misplaced(element: etree._Element, *, core: bool) -> Iterator[tuple[int, str]]:
    """What is allowed by itself, but not where or with what it stands."""
    tag, line = etree.QName(element).localname, line_of(element)
    children = [etree.QName(child).localname for child in element]
    for where, text in ((element, element.text), *((child, child.tail) for child in element)):
        if text and text.strip():
            found = f"found the text {text.strip()[:40]!r} inside <{tag}>"
            yield line_of(where), f"{found}, expected elements only"
    blocks = [child for child in children if child in _BLOCKS]
    rule = language(core=core).get(tag, _UNKNOWN)
    if rule.series:
        first = children.index(blocks[0]) if blocks else len(children)
        for child, name in zip(list(element)[first:], children[first:], strict=True):
            if name not in _BLOCKS and name in rule.children:
                yield (
                    line_of(child),
                    f"found <{name}> after a block of <{tag}>, expected before its first block",
                )
    if not (rule.children.issuperset(children) and rule.attributes.keys() >= set(element.attrib)):
        return  # an unknown name, which is reported already, may be a misspelling of what is missing
    if rule.series and not blocks:
        expected = ", ".join(f"<{name}>" for name in _BLOCKS if name in rule.children)
        yield line, f"<{tag}> has no blocks, expected one of {expected} inside"
    if tag == "objective" and bool(blocks) == ("activities" in element.attrib):
        found = "both activities and blocks" if blocks else "neither activities nor blocks"
        yield line, f"<objective> has {found}, expected activities (elementary) or blocks (recursive)"
    if tag == "objective" and blocks:
        of_both = {"activities", *(a.tag for a in form_of(Recursive).said(core=core))}
        for name in (str(name) for name in element.attrib if name not in of_both):
            yield line, f"<objective> has {name} and blocks, expected {name} on elementary objectives only"
    if tag == "objective" and blocks and "sets" in children:
        yield line, "<objective> has <sets> and blocks, expected <sets> in elementary objectives only"
    if tag == "activity" and "consumes" in element.attrib and "alternative" in children:
        yield line, "<activity> has both consumes and <alternative>, expected consumes on the alternatives"


def _contents(element: etree._Element) -> str:
    tag = etree.QName(element).localname
    rule = language().get(tag, _UNKNOWN)
    children = (
        ", ".join(dict.fromkeys(f"<{etree.QName(child).localname}>" for child in element)) or "no children"
    )
    expected = ", ".join(f"<{name}>" for name in sorted(rule.children))
    optional = ", ".join(sorted(rule.attributes.keys() - rule.required))
    return (
        f"<{tag}> with {', '.join(map(str, element.attrib)) or 'no attributes'} and {children} does not fit; "
        f"expected children among {expected or 'none'}, or an attribute among {optional or 'none'}"
    )
