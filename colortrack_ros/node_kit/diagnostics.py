"""What a node tells its operator: counters on /diagnostics and throttled log lines."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import field
from dataclasses import fields
import itertools
from statistics import median
import threading
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_msgs.msg import KeyValue
from rclpy.node import Node

from colortrack_ros.flow.stamps import StampWatch
from colortrack_ros.node_kit.clocks import Elapsed
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.losses import Losses
from colortrack_ros.node_kit.rivals import crowd_of
from colortrack_ros.node_kit.rivals import mismatch_of
from colortrack_ros.node_kit.rivals import rival_of
from colortrack_ros.node_kit.silence import unheard_by
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

PERIOD = 1.0
"""Interval [s] between messages: that of diagnostic_updater."""
TOLD_EVERY = 5.0
"""Least interval [s] between log lines about refused input, or a trouble that comes and goes.
Assumed: slow enough to read them all."""
LOGGED_AFTER = 5.0
"""How many times as long as diagnostics wait until the log has it, too: 10 s by default, in which
what is started along with a node, as a camera's driver, publishes. Assumed."""
OTHER_CLOCK = 3600.0
"""Stamps farther than this from now [s] are of another clock, as in an old recording, and give no
latency. As long as the longest threshold."""

NO_CLOCK = 'use_sim_time is true, but nobody publishes /clock, as `ros2 bag play --clock` does'

TASK = 'messages'
"""Second part of the status name. As diagnostic_updater does, it follows the name of the node
without the slash; diagnostic_aggregator sorts by it (see params/diagnostics.yaml)."""

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def _limit(default: float, description: str) -> Any:
    return parameter(default, description, unit='s', limits=(0.0, 3600.0), audience=EXPERT)


@dataclass(frozen=True)
class HealthConfig(Config):
    """Thresholds of a node's diagnostics."""

    warn_latency: float = _limit(
        0.5, 'Median latency, since the stamp, above which diagnostics warn.'
    )
    error_latency: float = _limit(
        5.0, 'Median latency, since the stamp, above which diagnostics report an error.'
    )
    warn_silence: float = _limit(2.0, 'Time without input after which diagnostics warn.')
    error_silence: float = _limit(
        60.0, 'Time without input after which diagnostics report an error.'
    )


@dataclass
class _Counts:
    """The counts of one period."""

    taken: int = 0
    given: int = 0
    refused: int = 0
    latencies: list[float] = field(default_factory=list)


class Health:
    """Counts what a node receives, publishes, skips and refuses, and publishes the counts every
    second.

    :param node: whose health it is, with the parameters of HealthConfig.
    :param trouble: returns what is wrong at the moment, empty if nothing is.
    :param facts: further values to show, as functions that return them.
    :ivar losses: of the pictures that the node takes.
    """

    def __init__(
        self, node: Node, trouble: Callable[[], str] = str, **facts: Callable[[], object]
    ) -> None:
        self.refused, self.losses = 0, Losses()
        self._node, self._trouble, self._facts = node, trouble, facts
        source = node.get_parameter_or('source')
        self._hardware = str(source.value or 'none')  # as displayed, without a password
        self._lock = threading.Lock()
        self._counts = _Counts()
        self._reason = self._still = self._logged = ''
        self._noted: tuple[str, ...] = ()
        self._noted_at = dict[str, float]()
        self._noted_level = ERROR
        self._stamps = StampWatch()
        self._told, self._once = -TOLD_EVERY, set[str]()
        self._seconds = Elapsed(node)
        self._heard = self._seconds()
        self._publisher = publish_on(node, DiagnosticArray, '/diagnostics')
        node.create_timer(PERIOD, self.publish, clock=STEADY)

    def note(self, *troubles: str, level: bytes = ERROR) -> None:
        """Log what is wrong with a picture, each trouble once until it is over.

        One that comes and goes is logged every TOLD_EVERY seconds. Nothing refused keeps one from
        the log, unless it has just been logged as that.

        :param troubles: empty where there is none, the worst first; each kind of trouble has its
            place.
        :param level: of the status until then.
        """
        for trouble, before in itertools.zip_longest(troubles, self._noted, fillvalue=''):
            if trouble and not before and trouble != self._logged:
                now = STEADY.now().nanoseconds * 1e-9
                recent = {t: at for t, at in self._noted_at.items() if now - at < TOLD_EVERY}
                if trouble not in recent:
                    self._node.get_logger().warning(trouble)
                self._noted_at = {trouble: now} | recent
        self._noted, self._noted_level, self._logged = troubles, level, ''

    def took_in(self) -> None:
        """Count a message or a frame that was received."""
        with self._lock:
            self._counts.taken += 1
            self._heard = self._seconds()

    def gave_out(self, stamp: int, *, repeated: bool = False) -> None:
        """Count a message that was published.

        :param stamp: of its header, or of what it follows from [ns].
        :param repeated: whether many may follow from one message, so that stamps may stand still.
        """
        latency = (self._node.get_clock().now().nanoseconds - stamp) * 1e-9
        with self._lock:
            still = '' if repeated else self._stamps.see(stamp)
            tell = still != '' and self._still == ''
            self._still = still
            self._counts.given += 1
            if abs(latency) < OTHER_CLOCK:
                self._counts.latencies.append(latency)
        if tell:
            self._node.get_logger().warning(still)

    def refuse(self, reason: str) -> None:
        """Count invalid input, and log the reason at most once every TOLD_EVERY seconds."""
        now = STEADY.now().nanoseconds * 1e-9
        with self._lock:
            self.refused += 1
            self._counts.refused += 1
            self._reason = reason
            tell = now - self._told >= TOLD_EVERY
            self._told = now if tell else self._told
        if tell:  # the logger's own throttling takes longer than refusing
            self._logged = reason
            self._node.get_logger().warning(f'Refused: {reason}')

    def publish(self) -> None:
        """Publish the counts since the last time."""
        with self._lock:
            counts, self._counts = self._counts, _Counts()
            active = getattr(self._node, 'active', True)
            self._heard = self._heard if active else self._seconds()
            silence = self._seconds() - self._heard
            refused, reason = self.refused, self._reason
        latency = median(counts.latencies) if counts.latencies else None
        level, message = self._judge(counts, latency, silence) if active else (OK, 'inactive')
        values = {
            'rate in [Hz]': f'{counts.taken / PERIOD:.1f}',
            'rate out [Hz]': f'{counts.given / PERIOD:.1f}',
            'latency from stamp, median [ms]': f'{latency * 1e3:.1f}' if latency else 'none',
            'refused': refused,
            'last refusal': reason,
            **{name.replace('_', ' '): fact() for name, fact in self._facts.items()},
        }
        status = DiagnosticStatus(
            level=level,
            name=f'{self._node.get_fully_qualified_name()[1:]}: {TASK}',
            message=message,
            hardware_id=self._hardware,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)

    def _judge(self, counts: _Counts, latency: float | None, silence: float) -> tuple[bytes, str]:
        """The level, and all that is wrong, the worst first."""
        findings = [finding for finding in self._findings(counts, latency, silence) if finding[1]]
        # what has passed both of its thresholds is told once
        texts = dict.fromkeys(text for _, text in findings)
        return (findings[0][0], '; '.join(texts)) if findings else (OK, 'working')

    def _findings(
        self, counts: _Counts, latency: float | None, silence: float
    ) -> tuple[tuple[bytes, str], ...]:
        """Levels and what is wrong, the worst first; empty where nothing is."""
        node = self._node
        names = [field.name for field in fields(HealthConfig)]
        limit = {name: node.get_parameter(name).value for name in names}
        late = 0.0 if latency is None else latency
        lateness = f'{late:.3f} s from stamp to output'
        unheard = unheard_by(node) if silence > limit['warn_silence'] else ''
        quiet = f'nothing has come in for {silence:.0f} s' + (f': {unheard}' if unheard else '')
        noted = '; '.join(filter(None, self._noted))
        crowd, mismatch = crowd_of(node), mismatch_of(node)
        self._log_once('crowd', crowd)
        self._log_once('mismatch', mismatch)
        lost = self.losses.tell()
        self._log_once('lost', lost)
        if unheard and silence > LOGGED_AFTER * limit['warn_silence']:
            self._log_once('silence', f'nothing has come in: {unheard}')
        return (
            (ERROR, self._trouble()),
            (ERROR, noted * (self._noted_level == ERROR)),
            (ERROR, lateness * (late > limit['error_latency'])),
            (ERROR, quiet * (silence > limit['error_silence'])),
            (WARN, noted),
            (WARN, NO_CLOCK * lacks_clock(node)),
            (WARN, rival_of(node)),
            (WARN, crowd),
            (WARN, mismatch),
            (WARN, lost),
            (WARN, self._still),
            (WARN, f'{counts.refused} refused: {self._reason}' * (counts.refused > 0)),
            (WARN, lateness * (late > limit['warn_latency'])),
            (WARN, quiet * (silence > limit['warn_silence'])),
        )

    def _log_once(self, kind: str, text: str) -> None:
        """Log what is wrong, unless that kind has been logged before."""
        if text and kind not in self._once:
            self._once.add(kind)
            self._node.get_logger().warning(text)
