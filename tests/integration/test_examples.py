"""The `>>>` examples of docstrings print what they show, and every function that ``riot`` offers has one."""

from __future__ import annotations

import doctest
import importlib
import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from fenced import ROOT

import riot

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
SPECIAL = "__geo_interface__"
"""A property that other libraries read."""

MODULES = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for package in ("riot", "pipeline", "studio")
    for path in (ROOT / package).rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


@pytest.fixture(scope="module")
def shapes() -> dict[str, Any]:
    """What the examples of methods take for granted: two shapes and the transform of one into the other."""
    house = riot.Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)], name="house")
    kite = riot.Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)], name="kite")
    return {"house": house, "kite": kite, "transform": riot.construct(house, kite)}


def offered() -> Iterator[tuple[str, Callable[..., Any]]]:
    """The functions that ``riot`` offers and the methods of its classes, by name; not of results and errors."""
    for name in riot.__all__:
        value = getattr(riot, name)
        if inspect.isfunction(value):
            yield name, value
        elif value in (riot.Shape, riot.Transform, riot.Trunks):
            for method, member in vars(value).items():
                function = member.fget if method == SPECIAL else getattr(member, "__func__", member)
                if inspect.isfunction(function) and (method == SPECIAL or not method.startswith("_")):
                    yield f"{name}.{method}", function


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module_run(
    name: str, shapes: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = doctest.testmod(importlib.import_module(name), extraglobs=shapes, optionflags=FLAGS)
    assert result.failed == 0


def test_every_function_that_riot_offers_has_an_example_that_runs(
    shapes: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    finder, runner = doctest.DocTestFinder(recurse=False), doctest.DocTestRunner(optionflags=FLAGS)
    without = []
    # Methods may be attached to a class from another module, where a search of modules does not see them.
    for name, function in offered():
        tests = finder.find(function, name, globs={**function.__globals__, **shapes})
        without += [test.name for test in tests if not test.examples]
        for test in tests:
            runner.run(test)
    assert without == []
    assert runner.summarize().failed == 0
