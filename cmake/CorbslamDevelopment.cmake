# What programs of others are built with: the part `push`, a library that driver programs load, and the
# part `dev`: headers, the generated code of the services, find_package(corbslam) and examples.
include(CMakePackageConfigHelpers)

set(CORBSLAM_CMAKE_FOLDER "${CMAKE_INSTALL_LIBDIR}/cmake/corbslam")
set(CORBSLAM_PUSH_CLIENT "${CMAKE_SOURCE_DIR}/client_agent/push_client")

install(TARGETS corbslam_push EXPORT corbslam_push_export
        LIBRARY COMPONENT push NAMELINK_COMPONENT dev)
install(EXPORT corbslam_push_export NAMESPACE corbslam:: FILE corbslam-push.cmake
        DESTINATION "${CORBSLAM_CMAKE_FOLDER}" COMPONENT dev)
install(FILES "${CORBSLAM_PUSH_CLIENT}/corbslam/push.h" "${CORBSLAM_PUSH_CLIENT}/corbslam/push.hpp"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/corbslam" COMPONENT dev)

install(TARGETS corbslam_proto EXPORT corbslam_api_export ARCHIVE COMPONENT dev)
install(EXPORT corbslam_api_export NAMESPACE corbslam:: FILE corbslam-api.cmake
        DESTINATION "${CORBSLAM_CMAKE_FOLDER}" COMPONENT dev)
install(DIRECTORY "${CMAKE_BINARY_DIR}/proto/generated/corbslam"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT dev FILES_MATCHING PATTERN "*.h")
install(DIRECTORY "${CMAKE_SOURCE_DIR}/proto/corbslam"
        DESTINATION "${CMAKE_INSTALL_DATADIR}/corbslam/proto" COMPONENT dev
        FILES_MATCHING PATTERN "*.proto")

write_basic_package_version_file("${CORBSLAM_DOCUMENTS}/corbslamConfigVersion.cmake"
                                 VERSION "${PROJECT_VERSION}" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_SOURCE_DIR}/cmake/corbslamConfig.cmake"
              "${CORBSLAM_DOCUMENTS}/corbslamConfigVersion.cmake"
        DESTINATION "${CORBSLAM_CMAKE_FOLDER}" COMPONENT dev)
install(DIRECTORY "${CORBSLAM_PUSH_CLIENT}/examples/"
        DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/corbslam-dev/examples" COMPONENT dev)

add_dependencies(installed corbslam_push corbslam_proto)
foreach(PART push dev)
  corbslam_install_papers(${PART})
endforeach()
