// The program of one robot, from a source to its map; with --server a part of a mission.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_

#include <string>

namespace corbslam {

// All of main: parses the flags of `program`, plays the source that they name, and returns the exit
// code (RunProgram). Kinds of sources beside the recorded layouts are registered before.
int RunRobot(const std::string& program, int argc, char** argv);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_PROGRAM_H_
