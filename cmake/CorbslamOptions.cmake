# Language level, warnings, sanitizers and where programs go.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

# Every x86 robot since 2009 has SSE4.2 and popcnt (docs/adr/0001-instruction-set.md); wider kernels
# are chosen at run time.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  add_compile_options(-march=x86-64-v2)
else()
  # Where processors multiply and add in one step, gcc would round a * b + c once, and differently for each
  # way that it arranges a function: pictures, features and codes would not be the ones of x86-64-v2.
  add_compile_options(-ffp-contract=off)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # With this, ccache takes files that use precompiled headers, too.
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros "${CCACHE_PROGRAM}")
endif()

# Carried by every target of ours, and by none of the generated code.
add_library(corbslam_warnings INTERFACE)
target_compile_options(corbslam_warnings INTERFACE -Wall -Wextra -Wconversion -Werror)
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  target_compile_options(corbslam_warnings INTERFACE -Wthread-safety)
else()
  # gcc 12 reports false positives of these inside Eigen and the standard library at -O3.
  target_compile_options(corbslam_warnings INTERFACE -Wno-maybe-uninitialized -Wno-array-bounds
                                                     -Wno-stringop-overflow -Wno-restrict)
endif()

if(CORBSLAM_BUILD_FUZZERS AND NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  message(FATAL_ERROR "CORBSLAM_BUILD_FUZZERS needs clang, this is ${CMAKE_CXX_COMPILER_ID}")
endif()
# The first finding ends the program.
if(CORBSLAM_BUILD_FUZZERS)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all
                      -fno-omit-frame-pointer -g1 -O1)
  add_link_options(-fsanitize=address,undefined)
elseif(CORBSLAM_SANITIZE)
  # Whole missions run in these builds: unoptimised, Eigen takes them some thirty times as long.
  add_compile_options(-fsanitize=${CORBSLAM_SANITIZE} -fno-sanitize-recover=all
                      -fno-omit-frame-pointer -g1 -O2)
  add_link_options(-fsanitize=${CORBSLAM_SANITIZE})
endif()

# Where the viewer's page is built, and installed from.
set(CORBSLAM_BUILT_PAGE "${CMAKE_BINARY_DIR}/viewer_page")
