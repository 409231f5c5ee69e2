"""What every associator takes and gives."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Associator(Protocol):
    """Chooses among candidate pairs."""

    def __call__(
        self, track: NDArray[np.intp], detection: NDArray[np.intp], gain: NDArray[np.float64]
    ) -> NDArray[np.intp]:
        """Choose pairs, each track and each detection at most once.

        :param track: (K,) track of each candidate pair.
        :param detection: (K,) detection of each candidate pair.
        :param gain: (K,) log-likelihood ratio of the pair against leaving both alone, positive.
        :return: indices of the chosen pairs, ascending.
        """
