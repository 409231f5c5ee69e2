"""What a node tells its operator: counters on /diagnostics and throttled log lines."""

from collections import Counter
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
from rclpy.qos import qos_check_compatible
from rclpy.qos import QoSCompatibility
from rclpy.topic_endpoint_info import TopicEndpointInfo

from colortrack_ros.flow.stamps import StampWatch
from colortrack_ros.messages import BOXES
from colortrack_ros.node_kit.clocks import Elapsed
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.runtime import OF_EVERY_NODE
from colortrack_ros.node_kit.silence import told_of_silence
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import SENSED
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter

PERIOD = 1.0
"""Interval [s] between messages: that of diagnostic_updater."""
TOLD_EVERY = 5.0
"""Least interval [s] between log lines about refused input. Assumed: slow enough to read them
all."""
OTHER_CLOCK = 3600.0
"""Stamps farther than this from now [s] are of another clock, as in an old recording, and give no
latency. As long as the longest threshold."""

NO_CLOCK = 'use_sim_time is true, but nobody publishes /clock, as `ros2 bag play --clock` does'

UNNAMED = '_NODE_NAME_UNKNOWN_'
"""What rmw calls the node of a topic's end before it has heard of that node."""

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
    """

    def __init__(
        self, node: Node, trouble: Callable[[], str] = str, **facts: Callable[[], object]
    ) -> None:
        self.refused = 0
        self._node, self._trouble, self._facts = node, trouble, facts
        source = node.get_parameter_or('source')
        self._hardware = str(source.value or 'none')  # as displayed, without a password
        self._lock = threading.Lock()
        self._counts = _Counts()
        self._reason = self._noted = self._still = self._logged = ''
        self._noted_level = ERROR
        self._stamps = StampWatch()
        self._told = -TOLD_EVERY
        self._seconds = Elapsed(node)
        self._heard = self._seconds()
        self._publisher = publish_on(node, DiagnosticArray, '/diagnostics')
        node.create_timer(PERIOD, self.publish, clock=STEADY)

    def note(self, trouble: str, level: bytes = ERROR) -> None:
        """Log what is wrong with a picture, once until it is over; empty if nothing is.

        Nothing refused keeps it from the log, unless it has just been logged as that.

        :param level: of the status until then.
        """
        if trouble and not self._noted and trouble != self._logged:
            self._node.get_logger().warning(trouble)
        self._noted, self._noted_level, self._logged = trouble, level, ''

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
        """The level and its reasons, the worst first."""
        names = [field.name for field in fields(HealthConfig)]
        limit = {name: self._node.get_parameter(name).value for name in names}
        late = 0.0 if latency is None else latency
        lateness = f'{late:.3f} s from stamp to output'
        quiet = told_of_silence(self._node, silence, limit['warn_silence'])
        refusal = f'{counts.refused} refused: {self._reason}'
        rival, trouble, noted = rival_of(self._node), self._trouble(), self._noted
        crowd = crowd_of(self._node)
        if crowd:
            self._node.get_logger().warning(crowd, once=True)
        mismatch = mismatch_of(self._node)
        if mismatch:
            self._node.get_logger().warning(mismatch, once=True)
        findings = (
            (ERROR, trouble, trouble != ''),
            (ERROR, noted, noted != '' and self._noted_level == ERROR),
            (ERROR, lateness, late > limit['error_latency']),
            (ERROR, quiet, silence > limit['error_silence']),
            (WARN, noted, noted != ''),
            (WARN, NO_CLOCK, lacks_clock(self._node)),
            (WARN, rival, rival != ''),
            (WARN, crowd, crowd != ''),
            (WARN, mismatch, mismatch != ''),
            (WARN, self._still, self._still != ''),
            (WARN, refusal, counts.refused > 0),
            (WARN, lateness, late > limit['warn_latency']),
            (WARN, quiet, silence > limit['warn_silence']),
        )
        return next(
            ((level, message) for level, message, found in findings if found), (OK, 'working')
        )


def rival_of(node: Node) -> str:
    """A warning if another node has this node's name or publishes its topics; otherwise empty."""
    name = node.get_name(), node.get_namespace()
    if node.get_node_names_and_namespaces().count(name) > 1:
        return (
            f'several nodes are called {node.get_fully_qualified_name()}, and any of them answers '
            'for it; give one another name, -r __node:=NAME'
        )
    # transforms are of all nodes, and wheels have no tf2_msgs to compare types with
    own = Counter(
        publisher.topic_name
        for publisher in node.publishers
        if getattr(publisher.msg_type, '__name__', '') != 'TFMessage'
    )
    for topic in sorted(set(own) - OF_EVERY_NODE):
        if node.count_publishers(topic) > own[topic]:
            return f'others publish on {topic} as well, and subscribers get both; remap one of them'
    return ''


def crowd_of(node: Node) -> str:
    """A warning if several publish what this node takes from one camera or robot; otherwise empty.

    Detections may be of several detectors.
    """
    for end in node.subscriptions:
        topic = end.topic_name
        if end.msg_type in SENSED and node.count_publishers(topic) > 1:
            giving = _of_known(node.get_publishers_info_by_topic(topic))
            names = sorted({f'{g.node_namespace.rstrip("/")}/{g.node_name}' for g in giving})
            if len(names) > 1:  # one that was killed and started again is known twice for a while
                return (
                    f'{" and ".join(names)} publish on {topic}, and their messages take turns: '
                    'expected one; remap the others'
                )
    return ''


def mismatch_of(node: Node) -> str:
    """A warning if QoS, or another type, keeps messages from this node, or its own from others;
    otherwise empty.
    """
    name = node.get_name(), node.get_namespace()
    topics = {end.topic_name for end in node.publishers}
    topics |= {end.topic_name for end in node.subscriptions}
    for topic in sorted(topics - OF_EVERY_NODE):
        giving = _of_known(node.get_publishers_info_by_topic(topic))
        taking = _of_known(node.get_subscriptions_info_by_topic(topic))
        for giver, taker in itertools.product(giving, taking):
            if name not in [(end.node_name, end.node_namespace) for end in (giver, taker)]:
                continue
            ends = f'{taker.node_name} gets nothing from {giver.node_name} on {topic}'
            if giver.topic_type != taker.topic_type:
                hint = ', see detections_type' * (giver.topic_type == BOXES)
                return f'{ends}: it takes {taker.topic_type}, not {giver.topic_type}{hint}'
            match, why = qos_check_compatible(giver.qos_profile, taker.qos_profile)
            if match == QoSCompatibility.ERROR and not _gets(taker, giver, taking):
                reasons = str(why).replace('ERROR: ', '').lower().strip('; ')
                return f'{ends}: {reasons}; see qos_overrides in doc/robot.md'
    return ''


def _of_known(ends: list[TopicEndpointInfo]) -> list[TopicEndpointInfo]:
    """Return the ends of nodes whose names have come."""
    return [end for end in ends if end.node_name != UNNAMED]


def _gets(
    taker: TopicEndpointInfo, giver: TopicEndpointInfo, taking: list[TopicEndpointInfo]
) -> bool:
    """Whether another subscription of the same node matches the publisher."""
    return any(
        qos_check_compatible(giver.qos_profile, end.qos_profile)[0] != QoSCompatibility.ERROR
        for end in taking
        if (end.node_name, end.node_namespace) == (taker.node_name, taker.node_namespace)
    )
