"""What a message that is refused raises."""


class MessageError(ValueError):
    """A message that contradicts itself or its contract: what was given, what was expected."""
