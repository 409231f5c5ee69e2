"""parameters: each one is declared once, as a field of the configuration that uses it."""

from colortrack_ros.parameters.config import build
from colortrack_ros.parameters.config import Config
from colortrack_ros.parameters.config import named
from colortrack_ros.parameters.config import parameter
from colortrack_ros.parameters.config import part
from colortrack_ros.parameters.spec import DOCUMENT
from colortrack_ros.parameters.spec import EXPERT
from colortrack_ros.parameters.spec import Spec
from colortrack_ros.parameters.spec import USER
from colortrack_ros.parameters.table import ParameterTable

__all__ = [
    'DOCUMENT',
    'EXPERT',
    'USER',
    'Config',
    'ParameterTable',
    'Spec',
    'build',
    'named',
    'parameter',
    'part',
]
