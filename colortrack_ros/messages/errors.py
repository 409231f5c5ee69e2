"""The error that a refused message raises."""


class MessageError(ValueError):
    """A message is inconsistent or violates its contract: what was given, and what was expected."""
