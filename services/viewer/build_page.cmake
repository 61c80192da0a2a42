# Builds the page of SOURCES in a folder of its own, WORK, into OUT. Without a network and without what
# npm has kept of it the page is missing, and everything else is built.
file(MAKE_DIRECTORY "${WORK}" "${OUT}")
file(COPY "${SOURCES}/" DESTINATION "${WORK}"
     PATTERN "node_modules" EXCLUDE PATTERN "dist" EXCLUDE PATTERN "gen" EXCLUDE PATTERN "out" EXCLUDE)
set(ENV{PROTO_DIR} "${PROTO}")
set(ENV{OUT_DIR} "${OUT}")
foreach(STEP "ci;--no-audit;--no-fund;--prefer-offline" "run;build")
  execute_process(COMMAND "${NPM}" ${STEP} WORKING_DIRECTORY "${WORK}" RESULT_VARIABLE RESULT
                  OUTPUT_VARIABLE OUTPUT ERROR_VARIABLE OUTPUT)
  if(NOT RESULT EQUAL 0)
    message(WARNING "The viewer's page could not be built; map_viewer will say so.\n${OUTPUT}")
    return()
  endif()
endforeach()
