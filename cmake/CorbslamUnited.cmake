# Several files of a library are compiled as one: most of what a compiler does is with headers that they
# share. Eight files of slam/features took 9.8 s one by one and 3.5 s together. Where two files of a library give the same name to
# different things of their own, one of them stands in compiled_alone.txt; better is another name. Each
# file still includes what it uses: the fuzzers' build and the checks by clang compile each alone. The
# presets that build everything once unite (release, arm64); whoever changes a file again and again
# compiles that file alone (dev).
option(CORBSLAM_UNITED "Compile several files of a library as one" OFF)
set(CORBSLAM_UNITED_FILES 8)
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU" OR CORBSLAM_SANITIZE)
  set(CORBSLAM_UNITED OFF)
endif()

file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/compiled_alone.txt" CORBSLAM_COMPILED_ALONE REGEX "^[^#]")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
             "${CMAKE_CURRENT_LIST_DIR}/compiled_alone.txt")
foreach(SOURCE IN LISTS CORBSLAM_COMPILED_ALONE)
  if(NOT EXISTS "${CMAKE_SOURCE_DIR}/${SOURCE}")
    message(FATAL_ERROR "cmake/compiled_alone.txt names ${SOURCE}, which is no file")
  endif()
endforeach()

# Has TARGET's SOURCES compiled together.
function(corbslam_unite TARGET)
  if(NOT CORBSLAM_UNITED)
    return()
  endif()
  set_target_properties(${TARGET} PROPERTIES UNITY_BUILD ON
                                             UNITY_BUILD_BATCH_SIZE ${CORBSLAM_UNITED_FILES})
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY "${CMAKE_SOURCE_DIR}"
             OUTPUT_VARIABLE FOLDER)
  foreach(SOURCE IN LISTS ARGN)
    if("${FOLDER}/${SOURCE}" IN_LIST CORBSLAM_COMPILED_ALONE)
      set_source_files_properties("${SOURCE}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
endfunction()
