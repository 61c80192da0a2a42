# One library a folder. Each function takes the target's name, then SOURCES and DEPS.

function(corbslam_library NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  if(ARG_SOURCES)
    add_library(${NAME} STATIC ${ARG_SOURCES})
    target_include_directories(${NAME} PUBLIC "${CMAKE_SOURCE_DIR}")
    target_link_libraries(${NAME} PUBLIC ${ARG_DEPS} PRIVATE corbslam_warnings)
    corbslam_precompile(${NAME})
    corbslam_unite(${NAME} ${ARG_SOURCES})
  else()
    add_library(${NAME} INTERFACE)
    target_include_directories(${NAME} INTERFACE "${CMAKE_SOURCE_DIR}")
    target_link_libraries(${NAME} INTERFACE ${ARG_DEPS})
  endif()
endfunction()

# Linked into every executable. What a test may take longer than its TIMEOUT.
set(CORBSLAM_IN_EXECUTABLES corbslam_warnings)
set(CORBSLAM_TIMEOUT_FACTOR 1)
if(CORBSLAM_SANITIZE OR CORBSLAM_BUILD_FUZZERS)
  set(CORBSLAM_TIMEOUT_FACTOR 5)
endif()
if(CMAKE_CROSSCOMPILING_EMULATOR)
  set(CORBSLAM_TIMEOUT_FACTOR 20)
endif()
if(CORBSLAM_SANITIZE STREQUAL "thread")
  add_library(corbslam_abseil_mutex OBJECT "${CMAKE_SOURCE_DIR}/tests/sanitize/abseil_mutex.cc")
  target_link_libraries(corbslam_abseil_mutex PUBLIC absl::synchronization ${CMAKE_DL_LIBS}
                                              PRIVATE corbslam_warnings)
  list(APPEND CORBSLAM_IN_EXECUTABLES corbslam_abseil_mutex)
endif()

if(CORBSLAM_BUILD_TESTS)
  add_library(corbslam_test_main STATIC "${CMAKE_SOURCE_DIR}/tests/support/test_main.cc")
  target_link_libraries(corbslam_test_main PUBLIC GTest::gmock PRIVATE corbslam_warnings)
endif()

function(corbslam_program NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPS} ${CORBSLAM_IN_EXECUTABLES})
  corbslam_precompile(${NAME})
  corbslam_unite(${NAME} ${ARG_SOURCES})
endfunction()

# A test program's executable, with GoogleTest.
function(corbslam_test_program NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  set_target_properties(${NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/tests")
  target_compile_options(${NAME} PRIVATE ${CORBSLAM_TEST_OPTIONS})
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPS} corbslam_test_main
                                        ${CORBSLAM_IN_EXECUTABLES})
  corbslam_precompile(${NAME} TEST)
  corbslam_unite(${NAME} ${ARG_SOURCES})
endfunction()

# A test binary; each of its cases is a test of ctest's own. DEFINITIONS are for its sources.
function(corbslam_test NAME)
  if(NOT CORBSLAM_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPS;LABELS;DEFINITIONS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  math(EXPR ARG_TIMEOUT "${CORBSLAM_TIMEOUT_FACTOR} * ${ARG_TIMEOUT}")
  corbslam_test_program(${NAME} SOURCES ${ARG_SOURCES} DEPS ${ARG_DEPS})
  target_compile_definitions(${NAME} PRIVATE ${ARG_DEFINITIONS})
  gtest_discover_tests(${NAME} TEST_PREFIX "${NAME}." NO_PRETTY_VALUES DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120
                       PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}")
endfunction()

function(corbslam_benchmark NAME)
  if(NOT CORBSLAM_BUILD_BENCHMARKS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${NAME} ${ARG_SOURCES})
  target_link_libraries(${NAME} PRIVATE ${ARG_DEPS} benchmark::benchmark
                                        ${CORBSLAM_IN_EXECUTABLES})
endfunction()

# Ends the configuration with an error where the program NAME links, over however many libraries, a
# target whose whole name matches REGEX.
function(corbslam_keep_apart NAME REGEX)
  # Only at the end is every target there.
  cmake_language(EVAL CODE
    "cmake_language(DEFER DIRECTORY [[${CMAKE_SOURCE_DIR}]] CALL corbslam_check_apart [[${NAME}]] [[${REGEX}]])")
endfunction()

function(corbslam_check_apart NAME REGEX)
  set(WAITING ${NAME})
  set(SEEN)
  # A list that ends with X-NOTFOUND would count as false.
  while(NOT WAITING STREQUAL "")
    list(POP_FRONT WAITING LINKED)
    if(NOT TARGET "${LINKED}" OR LINKED IN_LIST SEEN)
      continue()
    endif()
    list(APPEND SEEN "${LINKED}")
    if(LINKED MATCHES "^(${REGEX})$")
      message(FATAL_ERROR "${NAME} links ${LINKED}, and must not (${REGEX})")
    endif()
    get_target_property(LIBRARIES "${LINKED}" LINK_LIBRARIES)
    get_target_property(INTERFACE "${LINKED}" INTERFACE_LINK_LIBRARIES)
    foreach(LIBRARY IN LISTS LIBRARIES INTERFACE)
      string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" LIBRARY "${LIBRARY}")
      list(APPEND WAITING "${LIBRARY}")
    endforeach()
  endwhile()
endfunction()
