#!/usr/bin/env bash
# Guess: a value of a property of an asset administration shell, in the lexical form of its XSD type, is the same value when it has
#   been read and written.
# Package: PyPI basyx-python-sdk 2.2.0
# Seen: A date of a zone east of +11:59 becomes that date of a zone ten hours west and more, which begins a day later:
#   2020-01-01+14:00 becomes 2020-01-01-10:00, and a year likewise. The decimal 0.0000001 is written as 1E-7, which xs:decimal does
#   not have, and the year -0044 as -044, which xs:gYear does not have.
# Source: XML Schema part 2, 3.2.9 (time zones of dates), 3.2.3.1, 3.2.11; basyx/aas/model/datatypes.py; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q basyx-python-sdk==2.2.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from basyx.aas.model import datatypes

found = {}
for kind, text in (
    (datatypes.Date, "2020-01-01+11:00"),
    (datatypes.Date, "2020-01-01+13:00"),
    (datatypes.Date, "2020-01-01+14:00"),
    (datatypes.GYear, "2020+14:00"),
    (datatypes.Decimal, "0.0000001"),
    (datatypes.GYear, "-0044"),
    (datatypes.DateTime, "2020-01-01T00:00:00+14:00"),
):
    found[text] = datatypes.xsd_repr(datatypes.from_xsd(text, kind))
print(found)
assert found == {
    "2020-01-01+11:00": "2020-01-01+11:00",
    "2020-01-01+13:00": "2020-01-01-11:00",
    "2020-01-01+14:00": "2020-01-01-10:00",
    "2020+14:00": "2020-10:00",
    "0.0000001": "1E-7",
    "-0044": "-044",
    "2020-01-01T00:00:00+14:00": "2020-01-01T00:00:00+14:00",
}, "the behaviour has changed"
PYTHON
