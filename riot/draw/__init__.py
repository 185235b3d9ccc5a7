"""Pictures of a transform: one figure as SVG, PNG or PDF, and the swing as an animated SVG."""

from riot.draw.animate import animate_svg
from riot.draw.figure import draw_transform

__all__ = ["animate_svg", "draw_transform"]
