"""What a bag that cannot be read or written raises."""


class BagError(Exception):
    """A bag cannot be read or written: one line, what was given and what would work."""


class BagWriteError(Exception):
    """A message, or the end of a bag, cannot be written, as on a full disk: why, in one line."""
