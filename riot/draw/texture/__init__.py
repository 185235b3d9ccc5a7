"""Texture: pictures of the inputs, or patterns, carried into the pieces (theory §9). Ours."""
