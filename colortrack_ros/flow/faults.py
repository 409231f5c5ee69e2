"""What is said of an exception that nobody has thought of."""

from pathlib import Path
import traceback


def fault_of(error: Exception) -> str:
    """What failed, and where, in a line: why an item is refused, to be reported to us."""
    at = traceback.extract_tb(error.__traceback__)[-1]
    text = ' '.join(f'{type(error).__name__}: {error}'.split())
    return f'a fault of ours at {Path(at.filename).name}:{at.lineno}, please report it: {text}'
