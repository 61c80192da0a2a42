// client_agent runs a robot on what its camera recorded in one of the public layouts.
#include "services/programs/robot_program.h"

int main(int argc, char** argv) { return corbslam::services::RunRobot("client_agent", argc, argv); }
