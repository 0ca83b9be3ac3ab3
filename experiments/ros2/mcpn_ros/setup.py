"""The package, as ament_python builds it; mcpn itself comes by pip."""

from setuptools import setup

setup(
    name="mcpn_ros",
    version="0.1.0",
    packages=["mcpn_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/mcpn_ros"]),
        ("share/mcpn_ros", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    license="MIT",
    entry_points={"console_scripts": ["mission_controller = mcpn_ros.node:main"]},
)
