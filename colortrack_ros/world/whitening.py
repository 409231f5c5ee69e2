"""What makes errors of known covariances independent ones of variance 1: W S W^T = 1."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def whitening(S: Floats) -> Floats:
    """The inverses W of the Cholesky factors of covariances S, (..., M, M), lower triangular.

    Gauss's elimination of all at once, row by row, beside the identity: for the few rows of a
    measurement, a third of the time that np.linalg takes.
    """
    count = S.shape[-1]
    A = np.zeros((count, 2 * count, S.size // count**2))
    A[:, :count] = S.reshape(-1, count, count).transpose(1, 2, 0)
    A[np.arange(count), np.arange(count, 2 * count)] = 1.0
    for i in range(count):
        row = A[i, i : count + i + 1]
        row /= np.sqrt(row[0])
        A[i + 1 :, i + 1 : count + i + 1] -= row[1 : count - i, None] * row[1:]
    return np.ascontiguousarray(A[:, count:].transpose(2, 0, 1)).reshape(S.shape)


def log_volume(W: Floats) -> Floats:
    """Half the logs, (...), of the determinants of 1 / S."""
    return np.asarray(np.log(np.einsum('...ii->...i', W)).sum(axis=-1))
