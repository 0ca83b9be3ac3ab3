#!/usr/bin/env bash
# Guess: a position of a message, float64[3], that is given as numpy.array([1, 2, 3]) is written as 1, 2, 3, or refused, as an
#   array of two numbers is.
# Package: PyPI rosbags 0.11.9 (with numpy 2.4.6)
# Seen: The integers' bits are taken for those of floats: 5e-324, 1e-323, 1.5e-323 are in the bag, without a word. So are an
#   int32 array in a float32 field, and a float64 one in an int64 field: 1.0 becomes 4607182418800017408. Types of another size
#   are refused by a ValueError about memory views.
# Source: rosbags/serde/cdr.py (val.view(numpy.uint8), where val is as the caller has made it); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q rosbags==0.11.9 numpy==2.4.6 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

store = get_typestore(Stores.ROS2_HUMBLE)


def stored(kind, array):
    # What comes back of an array in a field of this type.
    name = f"own_msgs/msg/{kind.capitalize()}"
    if name not in store.types:
        store.register(get_types_from_msg(f"{kind}[3] values\n", name))
    try:
        written = store.serialize_cdr(store.types[name](values=array), name)
    except ValueError as error:
        return str(error)
    return store.deserialize_cdr(written, name).values.tolist()


found = {
    "int64 in float64": stored("float64", np.array([1, 2, 3])),
    "int32 in float32": stored("float32", np.array([1, 2, 3], dtype=np.int32)),
    "float64 in int64": stored("int64", np.array([1.0, 2.0, 3.0])),
    "int64 in float32": stored("float32", np.array([1, 2, 3])),
}
print(*found.items(), sep="\n")
assert found["int64 in float64"] == [5e-324, 1e-323, 1.5e-323], "the behaviour has changed"
assert all(0 < value < 1e-40 for value in found["int32 in float32"]), "the behaviour has changed"
assert found["float64 in int64"][0] == 4607182418800017408, "the behaviour has changed"
assert "memoryview" in found["int64 in float32"], "the behaviour has changed"
PYTHON
