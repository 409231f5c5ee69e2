"""The signals that shut a program down in an orderly way."""

from collections.abc import Callable
import signal

INTERRUPTED = 128 + signal.SIGINT
"""Exit status after Ctrl-C, as of a program that it kills in a shell."""

PIPE_CLOSED = 128 + signal.SIGPIPE
"""Exit status when nobody reads the output any more, as of a program that SIGPIPE kills."""


def ending_signals() -> tuple[signal.Signals, ...]:
    """SIGINT, SIGTERM, and SIGHUP, which a closed terminal sends, unless nohup has it ignored."""
    usual = signal.SIGINT, signal.SIGTERM
    ignored = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    return usual if ignored else (*usual, signal.SIGHUP)


def on_ending_signals(call: Callable[[], object]) -> None:
    """Install a handler for them, in the main thread."""
    for number in ending_signals():
        signal.signal(number, lambda *_: call())


def ignore_ending_signals() -> None:
    """Ignore them from now on, in a program that is already ending."""
    for number in ending_signals():
        signal.signal(number, signal.SIG_IGN)
