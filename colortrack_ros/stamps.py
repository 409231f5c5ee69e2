"""What a stamp has to be."""

from numbers import Integral


def require_stamp(stamp: int) -> None:
    """Refuse a stamp that is no whole number, as of seconds, in which nothing would move.

    :param stamp: [ns].
    :raises ValueError: it is none.
    """
    if not isinstance(stamp, Integral):
        raise ValueError(
            f'stamp: expected whole nanoseconds (int), got {stamp!r}; of seconds they are '
            'round(seconds * 1e9)'
        )
