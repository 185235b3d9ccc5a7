"""The web server of the studio: pages, files and messages, for browsers on this machine that know the token alone."""
