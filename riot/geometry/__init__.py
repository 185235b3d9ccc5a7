"""From pictures, vector files and polygons to shapes (paper §6)."""
