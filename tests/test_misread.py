"""Texts that are no XML: for each there is a sentence of ours, none where the parser's words are all."""

from __future__ import annotations

import pytest
from lxml import etree

from mcpn.misread import sentence

NO_XML = """
<a><b 1="x"/></a>
<a></a
<a><b></b x></a>
<?xml version="1.0"
<?xml version="1.0" encoding=utf?><a/>
<?xml version="1.0" standalone="maybe"?><a/>
<?xml version="1.0" foo="x"?><a/>
<a><?pi</a>
<a><? x?></a>
<a><?xml x?></a>
<a xmlns:p="u" xmlns:q="u" p:x="1" q:x="2"/>
<p:q:a xmlns:p="u"/>
<a xmlns:xml="u"/>
<a xmlns:xmlns="u"/>
<a xmlns="http://www.w3.org/2000/xmlns/"/>
<a xmlns:b="%%"/>
<a xmlns:b=""/>
<:a/>
<a><![CDATA[x</a>
<a b="1"c="2"/>
<a/>x
<a>&#xZ;</a>
<a b="<"/>
<a b
<a b="
<a><!-- x
<a =""/>
<a/ >
< a/>
<a></>
<a></b>
<a>&lt</a>
<a>&b;</a>
<a>]]></a>
<?xml version="1.0" encoding="nope"?><a/>
<?xml version="2.0"?><a/>
<?pi:x y?><a/>
<a x:y="1"/>
text
""".strip().splitlines()


@pytest.mark.parametrize("text", NO_XML)
def test_what_is_no_xml_has_a_sentence(text: str) -> None:
    with pytest.raises(etree.XMLSyntaxError) as caught:
        etree.fromstring(text.encode())
    said = sentence(str(caught.value).removesuffix(" (<string>, line 1)"))
    place, _, told = said.removeprefix("not well-formed XML: ").partition(": ")
    assert place.startswith("column ")
    assert told
    assert "unparsable" not in told
