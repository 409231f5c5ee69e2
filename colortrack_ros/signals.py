"""The signals that end a program in order."""

from collections.abc import Callable
import signal


def ending_signals() -> tuple[signal.Signals, ...]:
    """SIGINT, SIGTERM, and SIGHUP, which a closed terminal sends; not that if nohup ignores it."""
    usual = signal.SIGINT, signal.SIGTERM
    ignored = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    return usual if ignored else (*usual, signal.SIGHUP)


def on_ending_signals(call: Callable[[], object]) -> None:
    """Have them call a function, in the main thread."""
    for number in ending_signals():
        signal.signal(number, lambda *_: call())


def ignore_ending_signals() -> None:
    """From now on, for a program that is ending anyway."""
    for number in ending_signals():
        signal.signal(number, signal.SIG_IGN)
