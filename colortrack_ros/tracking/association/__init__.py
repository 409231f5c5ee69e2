"""Associators by name. To add one, add a file here and a line to ASSOCIATORS."""

from colortrack_ros.tracking.association.base import Associator
from colortrack_ros.tracking.association.gnn import associate as gnn
from colortrack_ros.tracking.association.jpda import associate as jpda
from colortrack_ros.tracking.association.nearest import associate as nearest

ASSOCIATORS: dict[str, Associator] = {
    'gnn': gnn,
    'nearest': nearest,
    'jpda': jpda,
}

__all__ = ['ASSOCIATORS', 'Associator']
