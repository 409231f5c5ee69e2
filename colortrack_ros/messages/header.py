"""std_msgs/Header <-> stamp [ns] and frame_id."""

from std_msgs.msg import Header

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.messages.errors import MessageError


def stamp_of(header: Header) -> int:
    """The header's stamp [ns].

    :raises MessageError: nanosec is a second or more.
    """
    if header.stamp.nanosec >= NANOSECONDS:
        raise MessageError(f'stamp with {header.stamp.nanosec} ns: expected less than a second')
    return header.stamp.sec * NANOSECONDS + header.stamp.nanosec


def header_of(stamp: int, frame_id: str) -> Header:
    """A header with a stamp [ns]."""
    header = Header(frame_id=frame_id)
    header.stamp.sec, header.stamp.nanosec = divmod(stamp, NANOSECONDS)
    return header
