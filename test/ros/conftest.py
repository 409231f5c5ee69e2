from collections.abc import Iterator
from pathlib import Path

import pytest
from support.ros_domain import Ros


@pytest.fixture
def ros(tmp_path: Path) -> Iterator[Ros]:
    domain = Ros(tmp_path)
    yield domain
    domain.close()
