"""Built-in scenes."""

from colortrack_ros.data import Frame
from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes import Scene
from colortrack_ros.sources.base import RecordedSource
from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import Now

SCENE_PREFIX = 'scene:'


class SceneSource(RecordedSource):
    """A rendered scene at its own rate, `scene:five` or `scene:five?width=640&height=480`.

    :raises SourceError: if the scene or an option is unknown.
    """

    def __init__(self, spec: str, rate: float, clock: Now) -> None:
        try:
            self._scene: Scene = open_scene(spec[len(SCENE_PREFIX) :])
        except ValueError as error:
            raise SourceError(f'source {spec!r}: {error}') from None
        super().__init__(self._scene.rate)
        self.total = len(self._scene)
        self._next = 0

    @staticmethod
    def accepts(spec: str) -> bool:
        """Accept anything that starts with `scene:`."""
        return spec.startswith(SCENE_PREFIX)

    def read(self) -> Frame | None:
        """Render the next frame."""
        if self._next == self.total:
            return None
        frame = self._frame(self._scene.render(self._next))
        self._next += 1
        return frame

    def rewind(self) -> None:
        """Go back to the first frame."""
        self._next = 0
