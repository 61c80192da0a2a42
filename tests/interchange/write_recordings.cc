// Writes recordings of made-up missions into a folder, for other programs to read.
#include <cstdio>
#include <string>

#include "services/tool/export/mcap/testing/made_up_mission.h"

namespace corbslam::tests {
namespace {

int Write(const testing::MadeUpMission& mission, const std::string& path) {
  const absl::Status status = testing::Record(mission, path);
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s: %s\n", path.c_str(), std::string(status.message()).c_str());
  return 1;
}

// Returns a mission with points for several chunks.
testing::MadeUpMission MakeLargeMission() {
  testing::MadeUpMission large = testing::MakeUpMission();
  auto& points = large.moments.back().islands[testing::kAlphas].points;
  for (uint32_t i = 0; i < 600'000; ++i) {
    points[{testing::kAlphas, i}] = {static_cast<float>(i), 0, 1};
  }
  return large;
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  using corbslam::tests::Write;
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_recordings FOLDER\n");
    return 2;
  }
  const std::string folder = argv[1];
  return Write(corbslam::testing::MakeUpMission(), folder + "/small.mcap") +
         Write(corbslam::testing::MadeUpMission(), folder + "/empty.mcap") +
         Write(corbslam::tests::MakeLargeMission(), folder + "/large.mcap");
}
