#!/usr/bin/env bash
# Guess: A Darwin Core Archive read with python-dwca-reader has the same values by rows and as a table: the default of a
#   field is for the records that have none of their own.
# Package: PyPI python-dwca-reader 0.17.1 (with pandas 2.3.3)
# Seen: By rows it is so. In the table of pd_read() the default stands in all records: a datum or a basis of record that a
#   record states itself is written over.
# Source: Darwin Core text guide (attribute default of field); dwca/read.py (pd_read assigns the whole column); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q python-dwca-reader==0.17.1 pandas==2.3.3 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import zipfile

from dwca.read import DwCAReader

TERMS = "http://rs.tdwg.org/dwc/terms/"
meta = f"""<?xml version="1.0" encoding="UTF-8"?>
<archive xmlns="http://rs.tdwg.org/dwc/text/">
  <core encoding="UTF-8" fieldsTerminatedBy="," linesTerminatedBy="\\n" ignoreHeaderLines="1" rowType="{TERMS}Occurrence">
    <files><location>occurrence.csv</location></files>
    <id index="0"/>
    <field index="1" term="{TERMS}scientificName"/>
    <field index="2" term="{TERMS}geodeticDatum" default="WGS84"/>
  </core>
</archive>"""
with zipfile.ZipFile("archive.zip", "w") as archive:
    archive.writestr("meta.xml", meta)
    archive.writestr("occurrence.csv", "id,name,datum\n1,Gadus morhua,\n2,Calanus finmarchicus,ED50\n")
with DwCAReader("archive.zip") as reader:
    rows = [row.data[f"{TERMS}geodeticDatum"] for row in reader]
    table = list(reader.pd_read("occurrence.csv")["geodeticDatum"])
print("rows", rows)
print("table", table)
assert rows == ["WGS84", "ED50"], "the behaviour has changed"
assert table == ["WGS84", "WGS84"], "the behaviour has changed"
PYTHON
