"""Raw ``&`` and ``<`` in attributes: read as tinyxml2 reads them, with a warning, and nothing else is."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcpn.errors import InputError
from mcpn.trees.importing import translate
from mcpn.trees.ledger import in_words
from mcpn.trees.reading import read_forest
from mcpn.trees.tolerant import escaped


def tree(attribute: str) -> str:
    return f'<root BTCPP_format="4">\n<BehaviorTree ID="M">\n<a _skipIf={attribute}/>\n</BehaviorTree></root>'


@pytest.mark.parametrize(
    ("attribute", "value"),
    [
        ('"a && b"', "a && b"),
        ('"a < b"', "a < b"),
        ("'a<b && \"x\"'", 'a<b && "x"'),
        ('"a &amp;&amp; b & c &unknown; &#65;"', "a && b & c &unknown; A"),
        ('"a\n && b"', "a  && b"),
    ],
)
def test_what_is_read(attribute: str, value: str, tmp_path: Path) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(tree(attribute))
    forest = read_forest(path)
    assert forest.main.root.rules == {"_skipIf": value}
    assert all(w.source is not None and w.source.line in (3, 4) for w in forest.warnings)
    assert "is read as tinyxml2 reads it" in forest.warnings[0].message
    told = in_words(translate(forest, "m", "tree.xml").ledger)
    assert "warning: tree.xml:" in told


@pytest.mark.parametrize(
    "text",
    [
        tree('"a && b').replace("</root>", ""),
        tree('"a && b"').replace("</BehaviorTree>", ""),
        '<!DOCTYPE root [<!ENTITY a "&&">]>' + tree('"&a; && b"'),
        '<!DOCTYPE root SYSTEM "file:///etc/hostname">' + tree('"a && b"'),
        "<!-- && " + tree('"a && b"'),
    ],
)
def test_what_is_still_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(text)
    with pytest.raises(InputError):
        read_forest(path)


VALUES = st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"], exclude_characters='"\ufffe\uffff')


@given(value=st.text(VALUES))
def test_any_value_is_what_it_was(value: str) -> None:
    """Values whose ``&`` begin no entity come through as written; well-formed ones are not touched."""
    loose = value.replace("&", "& ")
    made, lines = escaped(f'<a b="{loose}"/>')
    assert etree.fromstring(made).get("b") == loose
    assert bool(lines) == ("&" in loose or "<" in loose)
    proper = etree.tostring(etree.Element("a", b=value), encoding="unicode")
    assert escaped(proper) == (proper, [])


@pytest.mark.parametrize("piece", ['<a x="', "<!--", "<a '", "&", "<", '"<', "<![CDATA[", "<?", '<a b="&<">'])
def test_what_never_closes_is_passed_once(piece: str) -> None:
    """Quadratic work on this would take minutes."""
    made, _ = escaped(piece * 300_000)
    assert len(made) >= 300_000 * len(piece)
