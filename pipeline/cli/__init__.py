"""The front door: the command ``riot`` over a mined collection, and what is said on the terminal."""
