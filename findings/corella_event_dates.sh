#!/usr/bin/env bash
# Guess: set_datetime takes what Darwin Core gives as examples of eventDate: a month, a year, a time with its zone, an interval;
#   what it does not take it refuses with a reason, and what is known to the month alone gets no day.
# Package: PyPI corella-python 0.1.5 (with pandas 3.1.1), of the Atlas of Living Australia
# Seen: "2020-03" becomes 1 March and "2020" 1 January. A time with Z or +10:00 and an interval end in a TypeError of pandas, for
#   dates with a zone cannot be compared with its limits (the interval's -05 is taken for one). What is older than 1970 is refused,
#   as a specimen of 1850.
# Source: Darwin Core, dwc:eventDate (examples 1809-02-12, 1906-06, 1971, 1963-03-08T14:07-06:00, 2007-11-13/15);
#   check_datetime.py; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q corella-python==0.1.5 pandas==3.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python -W ignore - <<'PYTHON' | grep -v '^Checking' | sed 's/ and 20.*//' | tee seen
import corella
import pandas

DATES = "2020-03-04 2020-03 2020 2020-03-04T10:00:00Z 2020-03-04T10:00:00+10:00 2020-01-01/2020-01-05 1850-03-04"
for date in DATES.split():
    try:
        found = corella.set_datetime(pandas.DataFrame({"date": [date]}), eventDate="date", string_to_datetime=True)
        said = str(found["eventDate"][0].date())
    except (TypeError, ValueError) as error:
        said = f"{type(error).__name__}: {str(error).split(chr(10))[-1] or str(error)}"
    print(date, "->", said)
PYTHON
cat > expected <<'TEXT'
2020-03-04 -> 2020-03-04
2020-03 -> 2020-03-01
2020 -> 2020-01-01
2020-03-04T10:00:00Z -> TypeError: Invalid comparison between dtype=datetime64[us, UTC] and datetime
2020-03-04T10:00:00+10:00 -> TypeError: Invalid comparison between dtype=datetime64[us, UTC+10:00] and datetime
2020-01-01/2020-01-05 -> TypeError: Invalid comparison between dtype=datetime64[us, UTC-05:00] and datetime
1850-03-04 -> ValueError: There are some invalid eventDate values.  They should be between 1970-01-01 00:00:00
TEXT
diff expected seen || { echo "the behaviour has changed"; exit 1; }
