# What is installed where, and as which part: common (the tool, the vocabulary, documents), server
# and robot.
include(GNUInstallDirs)

# Only what is installed is built for it.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY TRUE)
set(CORBSLAM_DOCUMENTS "${CMAKE_BINARY_DIR}/documents")
file(MAKE_DIRECTORY "${CORBSLAM_DOCUMENTS}")
find_program(GZIP_PROGRAM gzip REQUIRED)

# Programs say themselves what is in their manuals. CMake runs a target that is named by its
# name under the emulator, where the build has one.
function(corbslam_install_program NAME PART)
  set(PREFIX "${CORBSLAM_DOCUMENTS}/${NAME}")
  add_custom_command(
    OUTPUT "${PREFIX}.1.gz"
    COMMAND ${NAME} --man-page > "${PREFIX}.1"
    COMMAND "${GZIP_PROGRAM}" -9nf "${PREFIX}.1"
    DEPENDS ${NAME})
  add_custom_target(${NAME}_documents ALL DEPENDS "${PREFIX}.1.gz")
  add_dependencies(installed ${NAME} ${NAME}_documents)
  install(TARGETS ${NAME} RUNTIME COMPONENT ${PART})
  install(FILES "${PREFIX}.1.gz" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT ${PART})
  install(FILES "${CMAKE_SOURCE_DIR}/deploy/completion.bash" RENAME ${NAME}
          DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT ${PART})
  install(FILES "${CMAKE_SOURCE_DIR}/deploy/completion.bash" RENAME _${NAME}
          DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions" COMPONENT ${PART})
endfunction()

# A Debian package's own papers.
function(corbslam_install_papers PART)
  set(FOLDER "${CMAKE_INSTALL_DATADIR}/doc/corbslam-${PART}")
  install(FILES "${CMAKE_SOURCE_DIR}/deploy/debian/copyright" DESTINATION "${FOLDER}"
          COMPONENT ${PART})
  install(FILES "${CORBSLAM_DOCUMENTS}/changelog.gz" DESTINATION "${FOLDER}" COMPONENT ${PART})
endfunction()

add_custom_command(
  OUTPUT "${CORBSLAM_DOCUMENTS}/changelog.gz"
  COMMAND "${GZIP_PROGRAM}" -9nc "${CMAKE_SOURCE_DIR}/deploy/debian/changelog"
          > "${CORBSLAM_DOCUMENTS}/changelog.gz"
  DEPENDS "${CMAKE_SOURCE_DIR}/deploy/debian/changelog")
add_custom_target(changelog ALL DEPENDS "${CORBSLAM_DOCUMENTS}/changelog.gz")
# Everything that `cmake --install` wants to be there.
add_custom_target(installed DEPENDS changelog)
add_dependencies(installed viewer_page)

corbslam_install_program(corbslam common)
corbslam_install_program(map_store server)
corbslam_install_program(fusion_worker server)
corbslam_install_program(map_viewer server)
corbslam_install_program(client_agent robot)
corbslam_install_program(simulated_agent common)
foreach(PART common server robot)
  corbslam_install_papers(${PART})
endforeach()
if(CYCLONEDDS_FOUND)
  corbslam_install_program(corbslam_ros2 ros2)
  corbslam_install_papers(ros2)
  install(FILES deploy/ros2/corbslam.launch.py deploy/ros2/corbslam.yaml deploy/ros2/nav2.yaml
          DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/corbslam-ros2/examples" COMPONENT ros2)
endif()

install(FILES "${CMAKE_SOURCE_DIR}/slam/vocabulary/data/corbslam.voc"
        DESTINATION "${CMAKE_INSTALL_DATADIR}/corbslam" COMPONENT common)
# The lab's diary is for those who work on the sources.
install(DIRECTORY "${CMAKE_SOURCE_DIR}/docs/" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/corbslam"
        COMPONENT common FILES_MATCHING PATTERN "*.md" PATTERN "lab" EXCLUDE)
# Where it was built. Of an empty name this would install the whole machine.
if(NOT CORBSLAM_BUILT_PAGE)
  message(FATAL_ERROR "CORBSLAM_BUILT_PAGE is empty")
endif()
install(DIRECTORY "${CORBSLAM_BUILT_PAGE}/" DESTINATION "${CMAKE_INSTALL_DATADIR}/corbslam/viewer" COMPONENT server
        OPTIONAL)
install(FILES deploy/systemd/map_store.service deploy/systemd/fusion_worker.service
              deploy/systemd/map_viewer.service deploy/systemd/corbslam_backup.service
              deploy/systemd/corbslam_backup.timer
        DESTINATION lib/systemd/system COMPONENT server)
install(FILES deploy/systemd/client_agent@.service DESTINATION lib/systemd/system COMPONENT robot)
# Beside /usr where that is the prefix, as the units have it; else below the prefix.
install(CODE [[
  set(FOLDER "${CMAKE_INSTALL_PREFIX}/etc/corbslam")
  if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
    set(FOLDER "/etc/corbslam")
  endif()]] COMPONENT server)
install(CODE "file(INSTALL \"${CMAKE_SOURCE_DIR}/deploy/systemd/map_store.env\"
                   \"${CMAKE_SOURCE_DIR}/deploy/systemd/fusion_worker.env\"
                   \"${CMAKE_SOURCE_DIR}/deploy/systemd/map_viewer.env\"
                   \"${CMAKE_SOURCE_DIR}/deploy/systemd/corbslam_backup.env\"
                   \"${CMAKE_SOURCE_DIR}/deploy/revoked/revoked_tokens\"
                   DESTINATION \"\${FOLDER}\")" COMPONENT server)
install(FILES deploy/systemd/client_agent-alpha.env
        DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/corbslam-robot/examples" COMPONENT robot)
