#!/usr/bin/env bash
# Guess: boxes of other annotations stay as they are in COCO: one of 40 x 20 pixels that CVAT has turned by 90 degrees is 20 x 40,
#   or refused; circles and polygons of labelme get the boxes around them, or are named as left out; a box of Pascal VOC around
#   a whole image of 100 x 50 pixels, 1 to 100 and 1 to 50, is 100 x 50.
# Package: PyPI globox 2.9.0
# Seen: The turn is passed by: 40 x 20. Circle and polygon are left out without a word. The whole image is 99 x 49 from (1, 1), for
#   VOC's pixels count from 1 and include the last.
# Source: CVAT's XML format (rotation of box); the development kit of Pascal VOC (pixels count from 1); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q globox==2.9.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import json
from pathlib import Path

from globox import AnnotationSet

Path("cvat.xml").write_text(
    '<annotations><version>1.1</version><image id="0" name="a.jpg" width="100" height="100">'
    '<box label="turned" occluded="0" xtl="10" ytl="10" xbr="50" ybr="30" rotation="90.0" z_order="0"/></image></annotations>'
)
shapes = {
    "circle": [[50, 50], [60, 50]],
    "polygon": [[10, 10], [30, 12], [20, 40]],
    "rectangle": [[10, 20], [30, 40]],
}
labelled = [
    {"label": name, "points": points, "group_id": None, "shape_type": name, "flags": {}} for name, points in shapes.items()
]
about = {"version": "5.0.1", "flags": {}, "imagePath": "a.jpg", "imageData": None, "imageHeight": 100, "imageWidth": 100}
Path("labelme").mkdir()
Path("labelme/a.json").write_text(json.dumps({**about, "shapes": labelled}))
Path("voc").mkdir()
Path("voc/a.xml").write_text(
    "<annotation><filename>a.jpg</filename><size><width>100</width><height>50</height><depth>3</depth></size><object>"
    "<name>all</name><bndbox><xmin>1</xmin><ymin>1</ymin><xmax>100</xmax><ymax>50</ymax></bndbox></object></annotation>"
)


def boxes(annotations):
    told = annotations.to_coco(auto_ids=True)
    names = {each["id"]: each["name"] for each in told["categories"]}
    return {names[each["category_id"]]: [*each["bbox"]] for each in told["annotations"]}


found = [
    boxes(AnnotationSet.from_cvat("cvat.xml")),
    boxes(AnnotationSet.from_labelme("labelme")),
    boxes(AnnotationSet.from_pascal_voc("voc")),
]
print(*found, sep="\n")
assert found == [
    {"turned": [10, 10, 40, 20]},
    {"rectangle": [10, 20, 20, 20]},
    {"all": [1, 1, 99, 49]},
], "the behaviour has changed"
PYTHON
