"""simulation: a robot with a differential drive and a camera in a room of colored things."""

from colortrack_ros.simulation.config import SimulationConfig
from colortrack_ros.simulation.config import Thing
from colortrack_ros.simulation.config import ThingConfig
from colortrack_ros.simulation.simulation import Simulation

__all__ = ['Simulation', 'SimulationConfig', 'Thing', 'ThingConfig']
