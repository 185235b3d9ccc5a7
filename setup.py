"""Packages of a wheel: those of the checkout, and conf/ as pipeline/conf, since a checkout has it at the top level."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["riot*", "pipeline*", "studio*"]), "pipeline.conf"],
    package_dir={"pipeline.conf": "conf"},
)
