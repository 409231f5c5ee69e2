# On ROS 2 Jazzy: docker build -f docker/jazzy.Dockerfile -t colortrack .
# docker run --rm --net host --shm-size 1g colortrack ros2 launch colortrack_ros colortrack.launch.xml
FROM ros:jazzy-ros-base
WORKDIR /ws
COPY . src/colortrack_ros
RUN apt-get update && rosdep update \
  && rosdep install --from-paths src --ignore-src -y --dependency-types exec \
  && rm -rf /var/lib/apt/lists/*
RUN . /opt/ros/jazzy/setup.sh && colcon build --packages-select colortrack_ros
RUN sed -i '$isource /ws/install/setup.bash' /ros_entrypoint.sh
CMD ["ros2", "launch", "colortrack_ros", "colortrack.launch.xml"]
