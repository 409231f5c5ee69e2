"""Build with colcon (ament_python) or pip."""

from glob import glob

from setuptools import find_packages
from setuptools import setup

NAME = 'colortrack_ros'

EXECUTABLES = {
    'camera': 'nodes.camera',
    'contour_tracker': 'nodes.contour_tracker',
    'detector': 'nodes.detector',
    'evaluate': 'tools.evaluate',
    'follower': 'nodes.follower',
    'locator': 'nodes.locator',
    'overlay': 'nodes.overlay',
    'pick_color': 'tools.pick_color',
    'pipeline': 'nodes.pipeline',
    'replay': 'replay.main',
    'simulator': 'nodes.simulator',
    'tracker': 'nodes.tracker',
    'tune': 'tools.tune',
    'tuner': 'tuner.main',
    'window_tracker': 'nodes.window_tracker',
}

# What a robot gets from apt: Jazzy as wheels, and the newest of the rest.
STANDALONE = [
    'ros-jazzy-rclpy',
    'ros-jazzy-common-interfaces',
    # Without a version it is Kilted; without the extra there is no middleware.
    'ros-rclpy[fastrtps]==7.1.6',
    'opencv-python-headless>=4.6',
    'numpy>=1.26',
    'scipy>=1.11',
    'PyYAML',
]

setup(
    name=NAME,
    version='0.2.0',
    description='Finds objects by their color and tracks them with a bank of Kalman filters',
    license='Apache-2.0',
    maintainer='colortrack_ros maintainers',
    maintainer_email='maintainers@colortrack-ros.org',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['py.typed'], f'{NAME}.tuner': ['page/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        (f'share/{NAME}/launch', glob('launch/*.launch.*')),
        (f'share/{NAME}/params', glob('params/*')),
        (f'share/{NAME}/rviz', glob('rviz/*')),
        (f'share/{NAME}/foxglove', glob('foxglove/*')),
    ],
    python_requires='>=3.10',
    install_requires=['setuptools'],
    extras_require={
        'cluster': ['distributed'],
        'standalone': STANDALONE,
        'demo': ['rich'],
        'docs': ['myst-parser==4.0.1', 'sphinx==8.1.3', 'sphinx-rtd-theme==3.0.2'],
        'replay': ['apsw', 'rich', 'rosbags>=0.11.6'],
        'tuner': ['aiohttp>=3.9'],
        'test': [
            'aiohttp>=3.9',
            'distributed',
            'hypothesis',
            'motmetrics',
            'playwright',
            'pytest',
            'pytest-rerunfailures',
            'pytest-xdist',
        ],
    },
    zip_safe=True,
    entry_points={
        'console_scripts': [
            f'{name} = {NAME}.commands:{file}' for name, file in EXECUTABLES.items()
        ]
    },
)
