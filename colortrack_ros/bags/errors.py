"""Errors of bags that cannot be read or written."""


class BagError(Exception):
    """A bag cannot be read or written: in one line, what was given and what would work."""


class BagWriteError(Exception):
    """A message or the index of a bag cannot be written, as on a full disk: why, in one line."""
