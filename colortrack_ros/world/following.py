"""Following: follow a target at a distance, never faster than the robot can stop.

Plain Python: takes poses, targets and the time; returns the speeds of a differential drive.
"""

from dataclasses import dataclass
import math

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.reaction import Commands
from colortrack_ros.world.reaction import TurnWatch
from colortrack_ros.world.view import jumped
from colortrack_ros.world.view import way_between

LONGEST_PERIOD = 0.05
"""Longest time between two commands [s]: the period of Nav2's controller server, at 20 Hz."""

LONGEST_STEP = 0.2
"""Longest time between two steps [s] over which speeds change; after a longer one, time has jumped.
Assumed: four times what lies between two commands."""

CREEPING, SLOW_FOR = 0.5, 2.0
"""Share of max_speed, and time [s]: a robot that may not drive faster than that for so long, since
its target is measured late, is told of. Chosen."""

FOLLOWING = 'following'

AHEAD = 0.1
"""How far a stamp may be ahead of the clock [s]: the offset between machines synchronized by
NTP."""


@dataclass(frozen=True)
class FollowingConfig(Config):
    """Distance, speed limits, and when to stop."""

    distance: float = parameter(
        1.0, 'Distance from base_frame to the target.', unit='m', limits=(0.1, 100.0)
    )
    max_speed: float = parameter(0.6, 'Speed that is not exceeded.', unit='m/s', limits=(0.0, 10.0))
    max_turn: float = parameter(
        1.5, 'Speed of turning that is not exceeded.', unit='rad/s', limits=(0.0, 10.0)
    )
    max_acceleration: float = parameter(
        1.0, 'Acceleration that is not exceeded.', unit='m/s^2', limits=(0.01, 100.0)
    )
    braking: float = parameter(
        3.0, 'Deceleration with which the robot stops.', unit='m/s^2', limits=(0.01, 100.0)
    )
    max_turn_acceleration: float = parameter(
        10.0,
        'Change of the speed of turning that is not exceeded.',
        unit='rad/s^2',
        limits=(0.01, 1000.0),
    )
    stop_within: float = parameter(
        0.3,
        'The robot stands this long after the target, or the odometry, was last measured; it '
        'drives no faster than it can brake until then.',
        unit='s',
        limits=(0.1, 10.0),
    )
    reaction: float = parameter(
        0.0,
        'How late the robot does what it is told: its dead time, and the time that it takes to get '
        'to two thirds of a speed. It has to be stopped earlier by as much.',
        unit='s',
        limits=(0.0, 1.5),
    )
    max_sigma: float = parameter(
        0.5,
        'A target whose place on the ground is less certain, standard deviation, is not followed.',
        unit='m',
        limits=(0.001, 100.0),
    )
    backwards: bool = parameter(
        False, 'Whether to drive backwards, unseeing, when the target is too near.'
    )
    gain: float = parameter(
        1.5,
        'Speed for each meter of distance that is too much.',
        unit='1/s',
        limits=(0.0, 100.0),
        audience=EXPERT,
    )
    turn_gain: float = parameter(
        3.0,
        'Speed of turning for each radian that the target is off the direction of driving.',
        unit='1/s',
        limits=(0.0, 100.0),
        audience=EXPERT,
    )

    def check(self) -> None:
        """Check that the robot can stand in time.

        :raises ValueError: it is too late for that.
        """
        if self.reaction and self.reaction + LONGEST_PERIOD >= self.stop_within:
            raise ValueError(
                f'stop_within: expected more than {self.reaction + LONGEST_PERIOD:g} s, after '
                f'which the robot begins to stop, by reaction, got {self.stop_within:g}'
            )


@dataclass(frozen=True)
class Target:
    """The target to follow.

    :param position: (2,) x, y in the fixed frame [m].
    :param velocity: (2,) [m/s].
    :param stamp: time of the position [ns].
    :param measured: time of the last measurement, no later than stamp [ns].
    :param sigma: standard deviation of the position along its worst axis [m].
    """

    position: Floats
    velocity: Floats
    stamp: int
    measured: int
    sigma: float = 0.0


class Following:
    """Controls the speed and turn rate of the robot.

    With the target at range r and bearing beta, u the direction to it and v_t its velocity, both in
    the frame of the robot, the commands are::

        v = (gain (r - distance) + u . v_t) cos(beta)
        w = turn_gain beta + (u x v_t + v sin(beta)) / r

    The second terms alone would keep range and bearing constant. Both speeds are limited so that
    the robot can brake to 0 by `stop_within` after the last measurement: it slows down if
    measurements are late, and stops if the target is lost. Range and bearing are those when the
    robot does what it is told now, after what it was told before.

    :ivar state: what the controller does and why, in words.
    :ivar slow: why it has driven slowly for long, in words; empty if it has not.
    :ivar commands: those given; whoever gives the robot another one, as to stand, notes it there.
    :ivar turns: whether the robot turns when it is told to.
    """

    def __init__(self, config: FollowingConfig) -> None:
        self.state, self.slow = 'no target yet', ''
        self._most: tuple[float, float] = math.inf, 0.0
        self._config = config
        self.commands, self.turns = Commands(), TurnWatch()
        self._target: Target | None = None
        self._stopped = False
        self._last: int | None = None
        self._base: tuple[int, Pose] | None = None
        self._since = 0

    @property
    def follows(self) -> bool:
        """Whether there is a target to follow."""
        return self.state == FOLLOWING

    def configure(self, config: FollowingConfig) -> None:
        """Apply changed parameters."""
        self._config = config

    def see(self, target: Target) -> None:
        """Update the target; one that is too uncertain counts as not measured.

        So does one measured before the robot's pose jumped: it belongs to another frame.
        """
        if target.sigma <= self._config.max_sigma and target.measured >= self._since:
            self._target = target

    def stop(self) -> None:
        """Stop at once, until go() is called."""
        self._stopped = True

    def go(self) -> None:
        """Follow again."""
        self._stopped = False

    def lose(self, why: str) -> None:
        """Forget the target, and stop until there is a new one."""
        self._target, self.state = None, why

    def step(self, now: int, base: Pose, at: int) -> tuple[float, float]:
        """Return the commanded speed [m/s] and turn rate [rad/s].

        :param now: [ns].
        :param base: last known pose of the robot in the fixed frame.
        :param at: time of that pose [ns].
        """
        dt = 0.0 if self._last is None else (now - self._last) / NANOSECONDS
        dt = dt if 0 <= dt <= LONGEST_STEP else 0.0
        self._last = now
        self._watch(base, at)
        self.turns.see(self.commands, at, base, self._config.reaction)
        speed, turn = self._next(now, base, at, dt)
        self.commands.give(now, speed, turn)
        return speed, turn

    def _next(self, now: int, base: Pose, at: int, dt: float) -> tuple[float, float]:
        """Return the speeds from now on, dt [s] after the last ones."""
        if self._stopped:
            self.state = 'stopped'
            return 0.0, 0.0
        left = self._time_left(now, at)
        self._watch_time(now, left)
        wanted = (0.0, 0.0)
        if left > 0 and self._target is not None:
            wanted = self._towards(self._target, now, base, at)
        return self._limited(wanted, left, dt)

    def _watch(self, base: Pose, at: int) -> None:
        """Lose the target if the robot's pose has jumped: its position is no longer valid."""
        last, self._base = self._base, (at, base)
        if last is None or at < last[0]:
            self._since = 0  # of a clock that has gone back
            return
        if jump := jumped(*way_between(last[1], base), (at - last[0]) / NANOSECONDS):
            self.lose(f'{jump}: odometry was reset, or two nodes publish it')
            self._since = at

    def _watch_time(self, now: int, left: float) -> None:
        """Note whether the time left [s] has been short for SLOW_FOR, even at its longest."""
        since, most = self._most
        if not self.follows or now < since:
            self._most, self.slow = (now, 0.0), ''
            return
        self._most = since, max(most, left)
        if now - since > SLOW_FOR * NANOSECONDS:
            config, fastest = self._config, self._config.braking * self._most[1]
            late = config.stop_within - LONGEST_PERIOD - config.reaction - self._most[1]
            self._most, self.slow = (now, 0.0), ''
            if fastest < CREEPING * config.max_speed:
                self.slow = (
                    f'it drives at {fastest:.2f} m/s at most, since target and odometry are '
                    f'{late:.2f} s old as they come, and it has to stand by stop_within, '
                    f'{config.stop_within:g} s: send them earlier, or set a larger stop_within'
                )

    def _time_left(self, now: int, at: int) -> float:
        """Return the time by which the robot has to stop [s]; 0 if it has to be stopped now."""
        if self._target is None:
            return 0.0
        unseen, unknown = ((now - t) / NANOSECONDS for t in (self._target.measured, at))
        config = self._config
        left = config.stop_within - LONGEST_PERIOD - config.reaction - max(unseen, unknown)
        if min(unseen, unknown) < -AHEAD:
            self.state = 'the clock has gone back behind the target or the odometry'
            return 0.0
        if left > 0:
            self.state = FOLLOWING
        elif unseen >= unknown:
            self.state = f'the target was last measured {unseen:.1f} s ago'
        else:
            self.state = f'the odometry is {unknown:.1f} s old'
        return min(max(left, 0.0), config.stop_within)

    def _towards(self, target: Target, now: int, base: Pose, at: int) -> tuple[float, float]:
        """Return the speeds that bring the target to the set distance, straight ahead."""
        config, reaction = self._config, round(self._config.reaction * NANOSECONDS)
        ahead_of = (now + reaction - target.stamp) / NANOSECONDS
        there, heading = self.commands.carried_out(base, at - reaction, now)
        away = target.position + target.velocity * ahead_of - there
        ahead = np.array([math.cos(heading), math.sin(heading)])
        left = np.array([-ahead[1], ahead[0]])
        x, y = float(ahead @ away), float(left @ away)
        distance = max(math.hypot(x, y), 1e-3)
        vx, vy = float(ahead @ target.velocity), float(left @ target.velocity)
        closing = config.gain * (distance - config.distance) + (x * vx + y * vy) / distance
        speed = closing * max(x / distance, 0.0)
        if not config.backwards:
            speed = max(speed, 0.0)
        speed = float(np.clip(speed, -config.max_speed, config.max_speed))
        sweep = (x * vy - y * vx) / distance + speed * y / distance
        return speed, config.turn_gain * math.atan2(y, x) + sweep / distance

    def _limited(
        self, wanted: tuple[float, float], time_left: float, dt: float
    ) -> tuple[float, float]:
        """Return the speeds within all limits; stopping in time takes priority over smoothness."""
        config = self._config
        limits = (
            (self.commands.last[0], config.max_acceleration, config.braking, config.max_speed),
            (self.commands.last[1], *(config.max_turn_acceleration,) * 2, config.max_turn),
        )
        limited = []
        for value, (last, faster, slower, most) in zip(wanted, limits, strict=True):
            up, down = (faster, slower) if last >= 0 else (slower, faster)
            value = float(np.clip(value, last - down * dt, last + up * dt))
            most = min(most, slower * time_left)
            limited.append(float(np.clip(value, -most, most)))
        return limited[0], limited[1]
