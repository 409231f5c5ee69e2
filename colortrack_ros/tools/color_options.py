"""Colors on the command line."""

import argparse

from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.detection.reference import MAX_TOLERANCE


def color_option(text: str) -> str:
    """The parameter of what is given as ``r,g,b``, ``#rrggbb``, or by name; empty if nothing is."""
    if (name := text.strip().lower()) in PRESETS:
        return f'preset:={name}'
    try:
        if name.startswith('#'):
            values = list(bytes.fromhex(name[1:]))
        else:
            values = [int(value) for value in text.split(',') if text]
        if text:
            ReferenceColor.from_rgb('color', values)
    except ValueError:
        told = (
            'expected r,g,b of 0..255 each, such as 220,60,40, #rrggbb, or one of '
            f'{", ".join(PRESETS)}, got {text!r}'
        )
        raise argparse.ArgumentTypeError(told) from None
    return f'rgb:={values}' if text else ''


def tolerance_option(text: str) -> str:
    """A tolerance as it is; may be empty."""
    try:
        right = not text or 0 <= float(text) <= MAX_TOLERANCE
    except ValueError:
        right = False
    if not right:
        raise argparse.ArgumentTypeError(f'expected 0..{MAX_TOLERANCE:g}, got {text!r}')
    return text
