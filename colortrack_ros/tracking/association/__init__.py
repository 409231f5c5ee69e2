"""Associators by name. A new one is a file beside these and a line in ASSOCIATORS."""

from colortrack_ros.tracking.association.base import Associator
from colortrack_ros.tracking.association.gnn import associate as gnn

ASSOCIATORS: dict[str, Associator] = {
    'gnn': gnn,
}

__all__ = ['ASSOCIATORS', 'Associator']
