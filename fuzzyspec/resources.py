"""Text files that belong to the compiler but lie outside its package: the grammar, the templates, the examples.

In a checkout they are the folders ``grammar/``, ``templates/`` and ``examples/`` beside the package. The wheel carries
the same files under ``fuzzyspec/_data/`` (see ``pyproject.toml``), and as package data every ``fuzzyspec/**/*.json``
(``fuzzyspec/syntax/table.json`` is the parser's table).
"""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Literal

Kind = Literal["grammar", "templates", "examples"]


def folder(kind: Kind) -> Traversable:
    """The folder that holds the texts of one kind, from the wheel or else from the checkout."""
    packed = files("fuzzyspec").joinpath("_data", kind)
    if packed.is_dir():
        return packed
    return Path(__file__).resolve().parent.parent / kind


def read_text(kind: Kind, name: str) -> str:
    """Text of one file; ``FileNotFoundError`` where the installation lacks it."""
    return folder(kind).joinpath(name).read_text(encoding="utf-8")
