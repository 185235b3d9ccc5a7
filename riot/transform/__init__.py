"""A transform as data: pieces, poses, certificate, fidelity, the ``.riot`` file (paper §3.1)."""
