# Builds for arm64 on amd64, both Debian 12: Debian's cross compiler, and the headers and libraries that
# deploy/arm64/make_sysroot.sh puts into CORBSLAM_ARM64_SYSROOT (of CMake, or of the environment;
# build/arm64_sysroot without it). Programs that the build itself runs are this machine's; those that it
# makes and runs (tests, and each program once, for its manual) are run by qemu.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

if(NOT CORBSLAM_ARM64_SYSROOT)
  set(CORBSLAM_ARM64_SYSROOT "$ENV{CORBSLAM_ARM64_SYSROOT}")
endif()
if(NOT CORBSLAM_ARM64_SYSROOT)
  cmake_path(SET CORBSLAM_ARM64_SYSROOT NORMALIZE "${CMAKE_CURRENT_LIST_DIR}/../../build/arm64_sysroot")
endif()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES CORBSLAM_ARM64_SYSROOT)
if(NOT EXISTS "${CORBSLAM_ARM64_SYSROOT}/.made")
  message(FATAL_ERROR "${CORBSLAM_ARM64_SYSROOT} has no arm64 libraries: "
                      "deploy/arm64/make_sysroot.sh ${CORBSLAM_ARM64_SYSROOT} puts them there")
endif()
set(CMAKE_SYSROOT "${CORBSLAM_ARM64_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH "${CORBSLAM_ARM64_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_DIR} "")
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${CORBSLAM_ARM64_SYSROOT}")
set(ENV{PKG_CONFIG_LIBDIR}
    "${CORBSLAM_ARM64_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${CORBSLAM_ARM64_SYSROOT}/usr/share/pkgconfig")

set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L "${CORBSLAM_ARM64_SYSROOT}")
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
