# The headers of other libraries that most files read, parsed once: two thirds of a cold build were
# parsing them. Each file still includes what it uses: the fuzzers' build and the checks by clang read
# everything without.
option(CORBSLAM_PRECOMPILE "Parse the headers of other libraries once" ON)
# Clang's builds are checks: they read all headers.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(CORBSLAM_PRECOMPILE OFF)
endif()

# A precompiled header is taken where the same macros are defined: these are what packages define for
# those who link them.
add_compile_definitions(NOMINMAX GFLAGS_IS_A_DLL=0 GLOG_CUSTOM_PREFIX_SUPPORT GTEST_HAS_PTHREAD=1)
if(CORBSLAM_PRECOMPILE)
  # Tells ccache which precompiled header was taken.
  add_compile_options(-fpch-preprocess)
endif()

set(CORBSLAM_HEADERS
  <algorithm> <array> <atomic> <chrono> <cmath> <cstddef> <cstdint> <cstring> <deque> <filesystem>
  <fstream> <functional> <limits> <map> <memory> <numbers> <numeric> <optional> <random> <set>
  <sstream> <string> <string_view> <thread> <tuple> <utility> <variant> <vector>
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU>
  <absl/base/thread_annotations.h> <absl/container/flat_hash_map.h>
  <absl/container/flat_hash_set.h> <absl/status/status.h> <absl/status/statusor.h>
  <absl/strings/match.h> <absl/strings/numbers.h> <absl/strings/str_cat.h>
  <absl/strings/str_format.h> <absl/strings/str_join.h> <absl/strings/str_replace.h>
  <absl/strings/str_split.h> <absl/strings/strip.h> <absl/synchronization/mutex.h>
  <absl/time/clock.h> <absl/time/time.h>)
set(CORBSLAM_TEST_HEADERS <gmock/gmock.h> <gtest/gtest.h>)
# Not CLI11's: its functions make every file that has them parsed 8 s slower to compile. Not the robot's
# own service: few files read it, and a change of it would compile all others again.
set(CORBSLAM_SERVICE_HEADERS
  <grpcpp/grpcpp.h>
  <corbslam/v1/fusion_worker_service.grpc.pb.h> <corbslam/v1/map_store_service.grpc.pb.h>)

# The test program's own code is not what is measured.
set(CORBSLAM_TEST_OPTIONS $<$<CONFIG:Release>:-O1>)

function(corbslam_add_precompiled KIND)
  cmake_parse_arguments(ARG "" "" "HEADERS;DEPS;OPTIONS" ${ARGN})
  set(OWNER corbslam_precompiled_${KIND})
  add_library(${OWNER} OBJECT "${CMAKE_SOURCE_DIR}/cmake/precompiled.cc")
  target_compile_options(${OWNER} PRIVATE ${ARG_OPTIONS})
  target_link_libraries(${OWNER} PRIVATE Eigen3::Eigen absl::status ${ARG_DEPS})
  target_precompile_headers(${OWNER} PRIVATE ${ARG_HEADERS})
endfunction()

# Gives TARGET the precompiled headers of its folder: what is below services, but for the simulator, or
# tests reads gRPC and the wire contract too. With TEST, GoogleTest.
function(corbslam_precompile TARGET)
  if(NOT CORBSLAM_PRECOMPILE)
    return()
  endif()
  set(KIND library)
  if(CMAKE_CURRENT_SOURCE_DIR MATCHES "^${CMAKE_SOURCE_DIR}/(services|tests)(/|$)" AND
     NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "^${CMAKE_SOURCE_DIR}/services/simulation(/|$)")
    set(KIND service)
  endif()
  if("TEST" IN_LIST ARGN)
    string(APPEND KIND _test)
  endif()
  target_precompile_headers(${TARGET} REUSE_FROM corbslam_precompiled_${KIND})
endfunction()

if(CORBSLAM_PRECOMPILE)
  corbslam_add_precompiled(library HEADERS ${CORBSLAM_HEADERS})
  if(NOT CORBSLAM_ONLY_KERNELS)
    corbslam_add_precompiled(service HEADERS ${CORBSLAM_HEADERS} ${CORBSLAM_SERVICE_HEADERS}
                             DEPS corbslam_proto)
  endif()
  if(CORBSLAM_BUILD_TESTS)
    corbslam_add_precompiled(library_test HEADERS ${CORBSLAM_HEADERS} ${CORBSLAM_TEST_HEADERS}
                             OPTIONS ${CORBSLAM_TEST_OPTIONS})
  endif()
  if(CORBSLAM_BUILD_TESTS AND NOT CORBSLAM_ONLY_KERNELS)
    corbslam_add_precompiled(service_test
                             HEADERS ${CORBSLAM_HEADERS} ${CORBSLAM_SERVICE_HEADERS}
                                     ${CORBSLAM_TEST_HEADERS}
                             DEPS corbslam_proto OPTIONS ${CORBSLAM_TEST_OPTIONS})
  endif()
endif()
