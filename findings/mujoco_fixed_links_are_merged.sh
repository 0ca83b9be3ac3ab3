#!/usr/bin/env bash
# Guess: A robot read from URDF has in MuJoCo a body for each of its links, by name.
# Package: PyPI mujoco 4.0.0
# Seen: Links at fixed joints are merged into what they are fixed to, and the first link into the world: of base, arm, tool and finger
#   arm and finger are left, with the mass of tool in arm. A camera or a sensor that is asked for by the name of its link is not
#   there. With <mujoco><compiler fusestatic="false"/></mujoco> in the URDF tool is a body of its own.
# Source: MuJoCo's XML reference, compiler, fusestatic: true by default for URDF; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q mujoco==4.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import mujoco

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def bodies(extension):
    links = "".join(f'<link name="{name}">{INERTIAL}</link>' for name in ("base", "arm", "tool", "finger"))
    joints = "".join(
        f'<joint name="{parent}_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for parent, child, kind in (
            ("base", "arm", "revolute"),
            ("arm", "tool", "fixed"),
            ("tool", "finger", "revolute"),
        )
    )
    model = mujoco.MjModel.from_xml_string(f'<robot name="r">{extension}{links}{joints}</robot>')
    return {model.body(number).name: float(model.body_mass[number]) for number in range(model.nbody)}


plain = bodies("")
kept = bodies('<mujoco><compiler fusestatic="false"/></mujoco>')
print(plain, kept)
assert plain == {"world": 0.0, "arm": 2.0, "finger": 1.0}, "the behaviour has changed"
assert "tool" in kept, "the behaviour has changed"
PYTHON
