"""Starts corbslam_ros2 on a RealSense's two infrared cameras; change the remappings for others (docs/ros2.md).

    ros2 launch ./corbslam.launch.py server:=SERVER:50051 agent:=alpha
"""
import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

HERE = os.path.dirname(os.path.abspath(__file__))

REMAPPINGS = {
    "visual_slam/image_0": "/camera/camera/infra1/image_rect_raw",
    "visual_slam/camera_info_0": "/camera/camera/infra1/camera_info",
    "visual_slam/image_1": "/camera/camera/infra2/image_rect_raw",
    "visual_slam/camera_info_1": "/camera/camera/infra2/camera_info",
}


def generate_launch_description():
    arguments = ["--ros-args", "--params-file", os.path.join(HERE, "corbslam.yaml")]
    for name, topic in REMAPPINGS.items():
        arguments += ["-r", f"{name}:={topic}"]
    return LaunchDescription([
        DeclareLaunchArgument("server", description="HOST:PORT of the map store"),
        DeclareLaunchArgument("mission", default_value="default"),
        DeclareLaunchArgument("agent", default_value="alpha"),
        # The program is no package of ROS 2, but a program of the system.
        ExecuteProcess(cmd=["corbslam_ros2", "--server", LaunchConfiguration("server"), "--mission",
                            LaunchConfiguration("mission"), "--agent", LaunchConfiguration("agent")] + arguments,
                       output="screen"),
    ])
