"""The jinja environment of every page: templates and static files are data of this package.

Text is escaped by jinja; an undefined name is an error. Ours.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from pipeline.report import formats
from pipeline.report.assets import TEMPLATES, read_asset
from pipeline.report.policy import policy
from pipeline.report.words import becomes
from riot.draw.animate import MOTION_STYLE
from riot.draw.palette import DARK, LIGHT
from riot.draw.svg_style import page_colours, page_style
from riot.errors import needs_extra

with needs_extra("mine"):
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")
"""Characters that neither HTML nor XML may hold, even escaped; names of files may."""


def render(template: str, **values: Any) -> str:
    """The text of a template with ``values``, which are escaped unless they are `Markup`.

    Characters that HTML forbids become U+FFFD. Equal values give equal text. Raises `jinja2.TemplateError`.

    >>> render("studies.html", run="a < b", studies=[]).count("a &lt; b")
    2
    """
    return FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", _environment().get_template(template).render(**values))


def style_sheet(*names: str) -> Markup:
    """The rules of all pages, the pictures' too, and of the static files ``names``; light or dark as the reader's
    system has it.

    >>> "prefers-color-scheme:dark" in style_sheet()
    True
    """
    rules = "".join(map(read_asset, ("page.css", *names)))
    colours = {"light": Markup(page_colours(LIGHT)), "dark": Markup(page_colours(DARK))}
    return Markup(render("style.css", rules=Markup(rules), pictures=Markup(page_style() + MOTION_STYLE), **colours))


def _asset(name: str) -> Markup:
    return Markup(read_asset(name))


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        auto_reload=False,
    )
    environment.filters.update(formats.FILTERS, becomes=becomes)
    environment.globals.update(asset=_asset, policy=policy, style_sheet=style_sheet, zip=zip)
    return environment
