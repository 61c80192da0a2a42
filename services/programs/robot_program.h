// Runs the program of one robot, from a source to its map; with --server as a part of a mission.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_

#include <string>

namespace corbslam::services {

// Does all of main: parses the flags of `program`, plays the source that they name, and returns the
// exit code (RunProgram). The caller registers kinds of sources beside the recorded layouts before.
int RunRobot(const std::string& program, int argc, char** argv);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_
