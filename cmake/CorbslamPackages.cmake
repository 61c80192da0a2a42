# Debian packages: cpack -G DEB. corbslam-common, corbslam-server,
# corbslam-robot, corbslam-push and corbslam-dev; and corbslam-ros2, where DDS is there.
set(CPACK_PACKAGE_NAME corbslam)
set(CPACK_PACKAGE_VENDOR "CORB-SLAM")
set(CPACK_PACKAGE_CONTACT "CORB-SLAM maintainers <maintainers@corbslam.invalid>")
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL common server robot push dev)
if(CYCLONEDDS_FOUND)
  list(APPEND CPACK_COMPONENTS_ALL ros2)
endif()
set(CPACK_STRIP_FILES ON)
# Some files are in /etc.
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_SET_DESTDIR ON)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# The first line is the short description.
set(CPACK_COMPONENT_COMMON_DESCRIPTION
    "visual SLAM of several robots: the tool and what all share\n\
The corbslam tool runs, simulates, measures, draws and administers missions.\n\
Here are also the vocabulary and the documents.")
set(CPACK_COMPONENT_SERVER_DESCRIPTION
    "visual SLAM of several robots: the servers\n\
The map store keeps every robot's map and has them fused; fusion workers verify\n\
overlaps, fuse maps and adjust bundles; the map viewer shows maps in browsers.\n\
With systemd units, not enabled.")
set(CPACK_COMPONENT_ROBOT_DESCRIPTION
    "visual SLAM of several robots: what runs on each\n\
The client agent tracks, maps and closes loops, and streams its map to a map\n\
store. With a systemd unit for each robot's name, not enabled.")
set(CPACK_COMPONENT_PUSH_DESCRIPTION
    "visual SLAM of several robots: the library of camera drivers\n\
Programs that give a robot on the same machine pictures load it. It needs libc\n\
alone.")
set(CPACK_COMPONENT_DEV_DESCRIPTION
    "visual SLAM of several robots: for building programs with it\n\
Headers for pushing pictures to a robot, the generated code and the .proto files\n\
of the gRPC services, a configuration for CMake, and examples.")
set(CPACK_COMPONENT_ROS2_DESCRIPTION
    "visual SLAM of several robots: a robot as a node of ROS 2\n\
A robot that takes its camera's pictures from ROS 2's topics and publishes its\n\
poses, frames and map there. It speaks DDS itself: no ROS 2 is needed.")
foreach(PART COMMON SERVER ROBOT PUSH DEV ROS2)
  string(TOLOWER ${PART} NAME)
  set(CPACK_DEBIAN_${PART}_PACKAGE_NAME "corbslam-${NAME}")
endforeach()
set(CPACK_DEBIAN_SERVER_PACKAGE_DEPENDS "corbslam-common (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_ROBOT_PACKAGE_DEPENDS "corbslam-common (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_ROS2_PACKAGE_DEPENDS "corbslam-common (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "corbslam-push (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
# For corbslam::api; corbslam::push needs neither.
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "libgrpc++-dev, libprotobuf-dev, pkg-config")
set(CPACK_DEBIAN_PUSH_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_PUSH_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/deploy/debian/push/triggers")
# Live cameras (docs/live.md).
set(CPACK_DEBIAN_ROBOT_PACKAGE_RECOMMENDS "gstreamer1.0-plugins-base, gstreamer1.0-plugins-good")
set(CPACK_DEBIAN_ROBOT_PACKAGE_SUGGESTS "libaravis-0.8-0")
set(CPACK_DEBIAN_COMMON_PACKAGE_SUGGESTS "corbslam-server, corbslam-robot")
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA
    "${CMAKE_SOURCE_DIR}/deploy/debian/server/conffiles"
    "${CMAKE_SOURCE_DIR}/deploy/debian/server/postinst"
    "${CMAKE_SOURCE_DIR}/deploy/debian/server/prerm"
    "${CMAKE_SOURCE_DIR}/deploy/debian/server/postrm")
set(CPACK_DEBIAN_ROBOT_PACKAGE_CONTROL_EXTRA
    "${CMAKE_SOURCE_DIR}/deploy/debian/robot/postinst"
    "${CMAKE_SOURCE_DIR}/deploy/debian/robot/prerm"
    "${CMAKE_SOURCE_DIR}/deploy/debian/robot/postrm")
include(CPack)
