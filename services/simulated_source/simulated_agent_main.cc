// simulated_agent is client_agent with a simulator in the place of its camera (docs/simulation.md).
#include "services/programs/robot_program.h"
#include "services/simulated_source/simulated_source.h"

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  return corbslam::services::RunRobot("simulated_agent", argc, argv);
}
