"""The paper's construction: arcs swung into the trunk are pushed until they tile it, nearly (paper §4.3, theory §8)."""

from riot.construction.laplacian.method import construct_laplacian

__all__ = ["construct_laplacian"]
