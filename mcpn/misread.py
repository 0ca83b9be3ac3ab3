"""What is wrong with a text that is no XML or no TOML, in sentences: the parsers' own words reach nobody."""

from __future__ import annotations

import re

_SENTENCES = (
    (r"Document is empty|Start tag expected", "found no element, expected one as <name>"),
    (r"Extra content at the end", "found more after the root element, expected the end of the file"),
    (
        r"Opening and ending tag mismatch: (\S+) line (\d+) and unparsable",
        "found </ without a name, expected </{0}>, which ends the element of line {1}",
    ),
    (
        r"Opening and ending tag mismatch: (\S+) line (\d+) and (\S+)",
        "found </{2}>, expected </{0}>, which ends the element of line {1}",
    ),
    (r"Premature end of data in tag (\S+) line (\d+)", "the file ends inside <{0}> of line {1}"),
    (r"Couldn't find end of Start Tag (\S+)", "found no > at the end of <{0}>"),
    (r"Specification mandates value for attribute (\S+)", "the attribute {0} has no value"),
    (r"AttValue: . or . expected", "the value of an attribute does not begin with a quote"),
    (r"AttValue", "the value of an attribute does not end with its quote"),
    (r"error parsing attribute name", "found a sign that begins no name, expected an attribute, > or />"),
    (r"expected '>'", "found no > behind the name of a closing tag"),
    (r"Namespaced Attribute (\S+) in '.*' redefined", "the attribute {0} is given twice"),
    (r"Attribute (?:\S+:)?(\S+) redefined", "the attribute {0} is given twice"),
    (r"Unescaped '<'", "found < in the value of an attribute, expected &lt;"),
    (r"xmlParseEntityRef: no name", "found & alone, expected &amp;"),
    (r"EntityRef: expecting", "found & without a ; behind the name, expected &amp;"),
    (r"Entity '(.*)' not defined", "found &{0}; which is not defined, expected &amp; for the sign"),
    (r"xmlParseCharRef|CharRef", "found a reference to a character that XML does not have"),
    (r"[iI]nvalid Char|invalid character|Invalid character", "found a character that XML does not have"),
    (r"Invalid bytes|not proper UTF-8|Input is not", "found bytes that are not of the encoding of the file"),
    (
        r"Namespace prefix (\S+)(?: for (\S+))? on (\S+) is not defined",
        "the prefix {0} of <{2}> is not declared",
    ),
    (r"Empty XML namespace", "a prefix is declared with no namespace"),
    (r"Excessive depth", "elements stand more than 256 deep in each other: the limit was hit"),
    (r"String not started", "a value of the XML declaration does not begin with a quote"),
    (r"standalone accepts", "standalone of the XML declaration is neither yes nor no"),
    (r"parsing XML declaration", "found no ?> where the XML declaration ends"),
    (r"PI names?\b|ParsePI", "found <? that begins no processing instruction, expected <?name text?>"),
    (
        r"Failed to parse QName '(.*)'",
        "found the name {0}, expected one : at most, a name on each side of it",
    ),
    (
        r"prefix mapped to wrong URI|xmlns prefix|xmlns namespace name",
        "xml and xmlns are prefixes of XML itself",
    ),
    (r"xmlns:?(\S*): '(.*)' is not a valid URI", "the namespace {1} is no URI"),
    (r"XML declaration allowed only", "found an XML declaration after the start of the file"),
    (r"CData section not finished", "the file ends inside a CDATA section"),
    (r"Comment not terminated", "the file ends inside a comment"),
    (r"Double hyphen|Comment must not contain", "found -- inside a comment"),
    (r"Sequence ']]>'", "found ]]> in a text, expected ]]&gt;"),
    (r"StartTag: invalid element name", "found < without the name of an element behind it, expected &lt;"),
    (r"Unsupported encoding:? *(\S+)", "the encoding {0} is not known"),
    (r"Unsupported version '(.*)'", "XML of version {0}, expected 1.0"),
    (
        r"Blank needed|attributes construct error",
        "found no space, quote or > after the value of an attribute",
    ),
    (r"[Ll]imit exceeded|XML_PARSE_HUGE|too long", "a name, text or value is too long: the limit was hit"),
)
"""By pattern of the parser's message, what to say; names and lines are those of its groups."""

_OF_TOML = (
    (r"Cannot declare .* twice", "found a table a second time, expected one"),
    (r"Cannot overwrite a value", "found a key a second time, expected one value for it"),
    (r"Duplicate inline table key '?([^'(]*)'?", "found the key {0} a second time, expected one"),
    (r"Cannot mutate", "found more of a table that has ended, expected all of it in its braces"),
    (r"Invalid statement|Invalid initial character", "found no key, expected key = value or [table]"),
    (r"Expected '=' after a key", "found a key alone, expected = and a value behind it"),
    (r"Invalid value", "found no value, expected a text in quotes, a number, true, false, [ or {{"),
    (r"Unterminated string|Expected \"'\"", "found a text without its end, expected a quote"),
    (r"Expected newline or end of document", "found more behind a value, expected the end of the line"),
    (r"Unclosed array", "found a list without its end, expected , or ]"),
    (r"Unclosed inline table", "found a table without its end, expected , or }}"),
    (r"Expected ['\"](\]+)['\"] at the end of", "found a table's name without its end, expected {0}"),
    (r"Illegal character|Found invalid character", "found a character that cannot stand here, expected text"),
    (
        r"Unescaped|Invalid hex|Escaped character",
        "found an escape that is none, expected \\\\ for a backslash",
    ),
    (r"Invalid date", "found a date that is none, expected one or a text in quotes"),
    (r"digits|int string conversion", "found a number of too many digits, expected fewer"),
    (r"recursion", "found lists or tables too deep in each other: the limit was hit"),
)


def of_toml(message: str) -> str:
    """What a message of Python's reader of TOML says, with the column where it has one.

    >>> of_toml("Invalid value (at line 3, column 5)")
    'not valid TOML: column 5: found no value, expected a text in quotes, a number, true, false, [ or {'
    """
    column = re.search(r"column (\d+)\)\s*\Z", message)
    where = f": column {column[1]}" if column else ""
    for pattern, said in _OF_TOML:
        if found := re.search(pattern, message):
            return f"not valid TOML{where}: {said.format(*found.groups())}"
    return f"not valid TOML{where}: found something else, expected TOML"


def sentence(message: str) -> str:
    """What a message of the parser says, with the column where it has one.

    >>> sentence("Opening and ending tag mismatch: b line 1 and a, line 3, column 11")
    'not well-formed XML: column 11: found </a>, expected </b>, which ends the element of line 1'
    >>> sentence("something new")
    'not well-formed XML'
    """
    column = re.search(r"column (\d+)\s*\Z", message)
    where = f": column {column[1]}" if column else ""
    for pattern, said in _SENTENCES:
        if found := re.search(pattern, message):
            groups = [(group or "").rstrip(",") for group in found.groups()]
            return f"not well-formed XML{where}: {said.format(*groups)}"
    return f"not well-formed XML{where}"
