"""Pictures of a transform: a figure, a strip of its motion, an animated SVG, a film, textures on the pieces.

Every picture is a `riot.draw.scene.Scene`: SVG, PNG and PDF show the same, and the same transform gives the same bytes.
Pictures change no result: nothing below imports this package, so that no score is computed again when a colour changes
(tests/unit/test_draw.py, test_scene_files.py, test_motion_pictures.py, test_piece_images.py, test_layers.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
