"""What a bag that cannot be read or written raises."""


class BagError(Exception):
    """A bag cannot be read or written: one line, what was given and what would work."""
