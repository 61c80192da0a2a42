# The kernels alone, with their tests (-DCORBSLAM_ONLY_KERNELS=ON, for `tests/check.sh --only arm64`): the
# folders whose code is written for an instruction set, and what these stand on. They want a few packages
# (deploy/arm64/packages_kernels.txt) where the whole tree wants gRPC, Ceres and others.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(absl REQUIRED)
find_package(glog REQUIRED)
find_package(GTest REQUIRED)
include(GoogleTest)

# OpenCV's own description of itself wants all of its libraries to be there.
find_path(CORBSLAM_OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(NAME core imgproc features2d calib3d)
  find_library(CORBSLAM_OPENCV_${NAME} opencv_${NAME} REQUIRED)
  add_library(opencv_${NAME} UNKNOWN IMPORTED)
  set_target_properties(opencv_${NAME} PROPERTIES IMPORTED_LOCATION "${CORBSLAM_OPENCV_${NAME}}"
                        INTERFACE_INCLUDE_DIRECTORIES "${CORBSLAM_OPENCV_INCLUDE}")
endforeach()

add_subdirectory(slam/util)
add_subdirectory(slam/geometry)
add_subdirectory(slam/camera)
add_subdirectory(slam/features)
add_subdirectory(slam/coding)
add_subdirectory(services/simulation)

# Programs of these folders that want more are described, and not built.
set(CORBSLAM_KERNEL_TESTS slam_util_test features_test slam_coding_test services_simulation_renderer_test)
add_custom_target(kernels DEPENDS ${CORBSLAM_KERNEL_TESTS})
