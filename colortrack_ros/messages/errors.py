"""The error that a refused message raises."""


class MessageError(ValueError):
    """A message that contradicts itself or its contract: what was given, what was expected."""
