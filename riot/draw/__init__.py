"""Pictures of a transform: one figure or a strip of its motion (SVG, PNG, PDF), the motion as animated SVG or film."""

from riot.draw.animate import animate_svg
from riot.draw.figure import draw_transform
from riot.draw.film import write_film
from riot.draw.strip import draw_strip

__all__ = ["animate_svg", "draw_strip", "draw_transform", "write_film"]
