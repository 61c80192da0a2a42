// corbslam_ros2 runs a robot on what its camera's driver publishes in ROS 2, and publishes where it
// is (docs/ros2.md). It speaks DDS itself: no ROS 2 is needed.
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/live/ros2/ros2_context.h"
#include "client_agent/live/ros2/ros2_source.h"
#include "client_agent/ros2/ros2_arguments.h"
#include "client_agent/ros2/ros2_parameters.h"
#include "services/command_line/command_line.h"
#include "services/programs/robot_program.h"
#include "services/ros2/ros2_companion.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using client_agent::MakeNodeOptions;
using client_agent::ParseRos2Arguments;
using client_agent::ReadRos2Settings;
using client_agent::Ros2Arguments;
using client_agent::Ros2Context;
using client_agent::Ros2Environment;
using client_agent::Ros2Names;
using client_agent::Ros2NodeOptions;
using client_agent::Ros2Parameters;
using client_agent::Ros2Settings;

constexpr char kProgram[] = "corbslam_ros2";
constexpr char kNode[] = "visual_slam";

absl::StatusOr<std::shared_ptr<Ros2Context>> MakeContext(const Ros2Arguments& arguments) {
  ASSIGN_OR_RETURN(const Ros2Names names, Ros2Names::Make(kNode, arguments.remaps));
  ASSIGN_OR_RETURN(Ros2Parameters parameters, Ros2Parameters::Read(arguments, names));
  ASSIGN_OR_RETURN(const Ros2Settings settings, ReadRos2Settings(names, parameters));
  ASSIGN_OR_RETURN(const Ros2NodeOptions options,
                   MakeNodeOptions(Ros2Environment::OfProcess(), names));
  return std::make_shared<Ros2Context>(names, settings, options);
}

// Returns the source that is named, or the only one that there is.
std::string SourceOf(const std::vector<std::string>& arguments) {
  constexpr char kFlag[] = "--source=";
  for (size_t i = 0; i < arguments.size(); ++i) {
    if (absl::StartsWith(arguments[i], kFlag)) return arguments[i].substr(sizeof(kFlag) - 1);
    if (arguments[i] == "--source" && i + 1 < arguments.size()) return arguments[i + 1];
  }
  return "";
}

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "%s: %s\n", kProgram, std::string(status.message()).c_str());
  return kWrongUsage;
}

int Main(int argc, char** argv) {
  auto arguments = ParseRos2Arguments({argv, argv + argc});
  if (!arguments.ok()) return Fail(arguments.status());
  const auto context = MakeContext(*arguments);
  if (!context.ok()) return Fail(context.status());
  if (!arguments->without_effect.empty()) {
    std::fprintf(stderr, "%s: without effect here: %s\n", kProgram,
                 absl::StrJoin(arguments->without_effect, ", ").c_str());
  }
  client_agent::RegisterRos2Source(*context);
  const std::string source = SourceOf(arguments->others);
  if (source.empty()) {
    arguments->others.push_back("--source=ros2:topics");
  } else if (!absl::StartsWith(source, "ros2:")) {
    return Fail(absl::InvalidArgumentError(absl::StrCat(
        "--source ", source, ": this program plays ros2:topics alone; client_agent plays others")));
  }
  std::vector<char*> others;
  for (std::string& other : arguments->others) others.push_back(other.data());
  others.push_back(nullptr);
  Ros2Companion companion(*context);
  return RunRobot(kProgram, static_cast<int>(others.size()) - 1, others.data(), &companion);
}

}  // namespace
}  // namespace corbslam::services

int main(int argc, char** argv) { return corbslam::services::Main(argc, argv); }
