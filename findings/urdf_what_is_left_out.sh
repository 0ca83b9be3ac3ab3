#!/usr/bin/env bash
# Guess: a joint of a robot's description without <axis> turns about 1 0 0, and <mimic> without multiplier and offset has 1 and 0,
#   since the format says so; both readers give these.
# Package: PyPI urdf_parser_py 0.0.4 and yourdfpy 0.0.60
# Seen: yourdfpy gives them. urdf_parser_py, ROS's own, has None for the axis, the multiplier and the offset: whoever multiplies gets
#   a TypeError, and only for robots whose file relies on the defaults.
# Source: https://wiki.ros.org/urdf/XML/joint (axis: defaults to 1 0 0; mimic: 1 and 0); found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q urdf_parser_py==0.0.4 yourdfpy==0.0.60 2>pip.log || { cat pip.log; exit 1; }
cat > robot.urdf <<'XML'
<robot name="arm">
  <link name="a"/><link name="b"/><link name="c"/>
  <joint name="elbow" type="revolute"><parent link="a"/><child link="b"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="wrist" type="revolute">
    <parent link="b"/><child link="c"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="elbow"/>
  </joint>
</robot>
XML
venv/bin/python - <<'PYTHON'
import yourdfpy
from urdf_parser_py.urdf import URDF

read = {joint.name: joint for joint in URDF.from_xml_file("robot.urdf").joints}
own = read["elbow"].axis, read["wrist"].mimic.multiplier, read["wrist"].mimic.offset
other = yourdfpy.URDF.load("robot.urdf", load_meshes=False).joint_map
filled = other["elbow"].axis.tolist(), other["wrist"].mimic.multiplier, other["wrist"].mimic.offset
print("urdf_parser_py:", own, "yourdfpy:", filled)
assert own == (None, None, None), "the behaviour has changed"
assert filled == ([1.0, 0.0, 0.0], 1.0, 0.0), "the behaviour has changed"
PYTHON
