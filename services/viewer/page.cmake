# Builds the page where node and npm are; map_viewer says so where they are not. What npm fetches is
# pinned by package-lock.json.
find_program(NODE_PROGRAM node)
find_program(NPM_PROGRAM npm)
set(CORBSLAM_PAGE_SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/page")
if(NODE_PROGRAM AND NPM_PROGRAM AND EXISTS "${CORBSLAM_PAGE_SOURCES}/package-lock.json")
  file(GLOB_RECURSE CORBSLAM_PAGE_FILES CONFIGURE_DEPENDS
       "${CORBSLAM_PAGE_SOURCES}/src/*" "${CORBSLAM_PAGE_SOURCES}/dev/*" "${CORBSLAM_PAGE_SOURCES}/build/*")
  file(GLOB CORBSLAM_PAGE_SETTINGS CONFIGURE_DEPENDS "${CORBSLAM_PAGE_SOURCES}/*.json")
  file(GLOB CORBSLAM_PAGE_PROTOS CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/proto/corbslam/v1/*.proto")
  add_custom_command(
    OUTPUT "${CORBSLAM_BUILT_PAGE}/index.html"
    COMMAND "${CMAKE_COMMAND}" "-DSOURCES=${CORBSLAM_PAGE_SOURCES}" "-DWORK=${CMAKE_BINARY_DIR}/viewer_page_work"
            "-DOUT=${CORBSLAM_BUILT_PAGE}" "-DPROTO=${CMAKE_SOURCE_DIR}/proto" "-DNPM=${NPM_PROGRAM}"
            -P "${CMAKE_CURRENT_SOURCE_DIR}/build_page.cmake"
    DEPENDS ${CORBSLAM_PAGE_FILES} ${CORBSLAM_PAGE_SETTINGS} ${CORBSLAM_PAGE_PROTOS} "${CMAKE_CURRENT_SOURCE_DIR}/build_page.cmake"
    COMMENT "Building the viewer's page"
    VERBATIM)
  add_custom_target(viewer_page ALL DEPENDS "${CORBSLAM_BUILT_PAGE}/index.html")
else()
  message(STATUS "The viewer's page is not built: no node and npm")
  add_custom_target(viewer_page)
endif()
