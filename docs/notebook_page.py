"""A notebook as a page of the guide: run anew, with what its cells show."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbclient import NotebookClient

SECONDS = 600
"""Longest time of a cell: the first use of a kernel compiles it."""

FRAME = '<table border="1" class="dataframe">'
"""How a table of pandas begins; the guide has its own style for tables."""


def run_notebook(path: Path, folder: Path) -> Any:
    """The notebook with its outputs, run in ``folder``, its commands those of this Python's environment.

    Raises `nbclient.exceptions.CellExecutionError` if a cell does.
    """
    notebook = nbformat.read(path, as_version=4)
    commands = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    client = NotebookClient(notebook, timeout=SECONDS, resources={"metadata": {"path": str(folder)}})
    return client.execute(env=os.environ | {"PATH": commands})


def notebook_page(path: Path) -> str:
    """The notebook, run, as Markdown."""
    with TemporaryDirectory() as folder:
        notebook = run_notebook(path, Path(folder))
    download = f"[Download this page as a notebook]({path.name})."
    return "\n\n".join([*(text for cell in notebook.cells for text in _cell(cell)), download, ""])


def _cell(cell: Any) -> Iterator[str]:
    if cell.cell_type == "markdown":
        yield cell.source
        return
    yield f"```python\n{cell.source}\n```"
    for output in cell.outputs:
        data = output.get("data", {})
        text = output.get("text", data.get("text/plain", ""))
        if "text/html" in data:
            yield f"<div>\n{data['text/html'].replace(FRAME, '<table>')}\n</div>"
        elif text and output.get("name") != "stderr":
            yield f"```text\n{text.rstrip()}\n```"
