"""Material for a bug report: the frame, the settings, the versions."""

from importlib.metadata import version
import io
import json
import platform
from typing import Any
import zipfile

import cv2
import numpy as np
import scipy

from colortrack_ros.encodings import writable_bgr
from colortrack_ros.tuner.view import png_of
from colortrack_ros.tuner.view import ShownFrame


def snapshot(view: ShownFrame, source: str, settings: str) -> bytes:
    """A zip file: frame.png, mask.png, settings.yaml, about.json.

    ``replay`` takes the first as a source and the third as its params file.

    :param source: what is played, without passwords.
    :param settings: as a params file.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, 'w', zipfile.ZIP_DEFLATED) as file:
        file.writestr('frame.png', png_of(writable_bgr(view.frame)))
        file.writestr('mask.png', png_of(view.labels))
        file.writestr('settings.yaml', settings)
        file.writestr('about.json', json.dumps(_about(view, source), indent=1) + '\n')
    return buffer.getvalue()


def _about(view: ShownFrame, source: str) -> dict[str, Any]:
    return {
        'source': source,
        'encoding': view.frame.encoding,
        **view.found(),
        'versions': {
            'colortrack_ros': version('colortrack_ros'),
            'python': platform.python_version(),
            'opencv': cv2.__version__,
            'numpy': np.__version__,
            'scipy': scipy.__version__,
            'system': platform.platform(),
        },
    }
