// Runs the program of one robot, from a source to its map; with --server as a part of a mission.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_

#include <string>

#include "services/programs/robot_companion.h"

namespace corbslam::services {

// Does all of main: parses the flags of `program`, plays the source that they name, and returns the
// exit code (RunProgram). The caller registers kinds of sources beside the recorded layouts before.
// `companion` is not owned; null: there is none.
int RunRobot(const std::string& program, int argc, char** argv,
             RobotCompanion* companion = nullptr);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_
