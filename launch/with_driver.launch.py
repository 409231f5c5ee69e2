"""The driver of a camera of yours, and the color tracker on its pictures.

``ros2 launch colortrack_ros with_driver.launch.py driver_package:=usb_cam
driver:=usb_cam_node_exe namespace:=front``. Copy it into a package of your own and put your driver,
with its parameters, in the place of the first node.
"""

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import AnyLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription

SHARE = get_package_share_directory('colortrack_ros')

ARGUMENTS = {
    'driver_package': ('colortrack_ros', 'Package of the driver'),
    'driver': ('camera', 'Executable of the driver'),
    'driver_params': (f'{SHARE}/params/colortrack.yaml', 'Parameters of the driver'),
    'image': ('camera/image_raw', 'What the driver calls its pictures'),
    'camera_info': ('camera/camera_info', 'What the driver calls its CameraInfo'),
    'params_file': (f'{SHARE}/params/colortrack.yaml', 'Parameters of detector and tracker'),
    'namespace': ('', 'Namespace of all nodes and topics'),
}
"""Default and description of each."""


def generate_launch_description() -> LaunchDescription:
    """The driver, and our nodes but for the camera."""
    given = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    driver = Node(
        package=given['driver_package'],
        executable=given['driver'],
        namespace=given['namespace'],
        parameters=[given['driver_params']],
        output='screen',
    )
    color_tracker = IncludeLaunchDescription(
        AnyLaunchDescriptionSource(f'{SHARE}/launch/colortrack.launch.xml'),
        launch_arguments={
            'camera': 'false',
            'image_topic': given['image'],
            'camera_info_topic': given['camera_info'],
            'params_file': given['params_file'],
            'namespace': given['namespace'],
        }.items(),
    )
    return LaunchDescription([*declared, driver, color_tracker])
