"""Describes unexpected exceptions."""

import os
from pathlib import Path
import traceback

PACKAGE = Path(__file__).parents[1]
STANDARD_LIBRARY = Path(os.__file__).parent
INSTALLED = {'site-packages', 'dist-packages'}
"""Folders with libraries."""


def fault_of(error: Exception) -> str:
    """What failed and where, in one line for a bug report.

    The place is the innermost one outside libraries, which raise because of what we passed to them.
    """
    frames = traceback.extract_tb(error.__traceback__)
    at = ([at for at in frames if not _is_of_library(Path(at.filename))] or frames)[-1]
    text = ' '.join(f'{type(error).__name__}: {error}'.split())
    return f'a fault of ours at {Path(at.filename).name}:{at.lineno}, please report it: {text}'


def _is_of_library(file: Path) -> bool:
    of_others = STANDARD_LIBRARY in file.parents or not INSTALLED.isdisjoint(file.parts)
    return of_others and PACKAGE not in file.parents
