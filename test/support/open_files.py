"""What is left open."""

from collections.abc import Iterator
import contextlib
import gc
import warnings


@contextlib.contextmanager
def nothing_left_open() -> Iterator[None]:
    """Python closes in silence what nobody has closed: here it fails."""
    gc.collect()  # what others have left
    gc.freeze()  # so that the next time what is there already, all tests, is not gone through
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter('always', ResourceWarning)
        yield
        gc.collect()
    gc.unfreeze()
    assert [str(w.message) for w in told if w.category is ResourceWarning] == []
