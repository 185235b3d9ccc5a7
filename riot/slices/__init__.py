"""Objects in the round as stacks of thick slices, each a puzzle that becomes another shape (paper Fig. 20). In mm."""

from riot.errors import ModelError
from riot.slices.assign import shortlists
from riot.slices.cut import Cut, Slice, Stack, cut
from riot.slices.make import Outcome, Puzzle, make_puzzles
from riot.slices.model import Model, read_model

__all__ = [
    "Cut",
    "Model",
    "ModelError",
    "Outcome",
    "Puzzle",
    "Slice",
    "Stack",
    "cut",
    "make_puzzles",
    "read_model",
    "shortlists",
]
