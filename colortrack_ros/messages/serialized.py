"""Serialized messages, as a subscription with ``raw=True`` or a bag hands them over."""

from typing import Any

from rclpy.serialization import deserialize_message

from colortrack_ros.messages.cdr import CdrError
from colortrack_ros.messages.cdr import Reader
from colortrack_ros.messages.errors import MessageError


def stamp_of_serialized(cdr: bytes) -> int:
    """The stamp [ns] of a serialized message that begins with a header.

    :raises MessageError: these are not the bytes of such a message, or the stamp is invalid.
    """
    try:
        return Reader(cdr).stamp()
    except CdrError as error:
        raise MessageError(f'not a serialized message with a header: {error}') from error


def message_of_serialized(cdr: bytes, kind: type) -> Any:
    """Deserialize a message.

    :raises MessageError: these are not the bytes of such a message.
    """
    try:
        return deserialize_message(cdr, kind)
    except (RuntimeError, ValueError) as error:  # not UTF-8
        raise MessageError(f'not a serialized {kind.__name__}: {len(cdr)} bytes') from error
