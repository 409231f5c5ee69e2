"""Where things are: the checkout, and the real media that are not part of it."""

import os
from pathlib import Path

ROOT = Path(__file__).parents[2]
DATA = Path(os.environ.get('COLORTRACK_DATA', ROOT.parent / 'shared' / 'data'))
