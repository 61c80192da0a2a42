// camera_feeder plays a stereo recording or a simulation as a camera does: at its rate, left beside
// right, with frames that are dropped, late or doubled, and unplugged for a while. The robot reads
// it by its own GStreamer pipeline (docs/testing.md).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/source/frame_reader.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"
#include "tests/live_camera/camera_server.h"
#include "tests/live_camera/feed_plan.h"

namespace corbslam::tests {
namespace {

using client_agent::FramesOf;
using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::ReadPerturbed;
using client_agent::SourceSpec;

constexpr double kMostBytes = 2e9;

struct Arguments {
  std::string source;
  int port = 0;
  double wait_s = 60;
  double rate_hz = 0;  // 0: the recording's own times.
  FeedOptions feed;
};

struct Pictures {
  std::vector<cv::Mat> side_by_side;
  std::vector<double> taken_s;
};

// All frames are drawn or read before the first is given: a camera has its pictures in time.
absl::StatusOr<Pictures> Prepare(const Arguments& arguments) {
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(arguments.source));
  ASSIGN_OR_RETURN(const auto reader, OpenReader(source));
  Pictures pictures;
  const std::vector<size_t> frames = FramesOf(source, reader->frame_count());
  for (size_t i = 0; i < frames.size(); ++i) {
    ASSIGN_OR_RETURN(const SensorImages images,
                     ReadPerturbed(*reader, frames[i], source.perturbation));
    if (images.right.empty()) return absl::InvalidArgumentError("only stereo pairs are fed");
    if (2.0 * static_cast<double>(images.grey.total() * frames.size()) > kMostBytes) {
      return absl::InvalidArgumentError(absl::StrCat(
          frames.size(), " frames do not fit into memory: select fewer (?frames=A:B)"));
    }
    cv::hconcat(images.grey, images.right, pictures.side_by_side.emplace_back());
    const double since_first_s = 1e-9 * static_cast<double>(reader->timestamp_ns(frames[i]) -
                                                            reader->timestamp_ns(frames[0]));
    pictures.taken_s.push_back(arguments.rate_hz > 0 ? static_cast<double>(i) / arguments.rate_hz
                                                     : since_first_s);
  }
  if (frames.empty()) return absl::InvalidArgumentError("the source has no frame");
  return pictures;
}

absl::Status Feed(const Arguments& arguments) {
  RETURN_IF_ERROR(Validate(arguments.feed));
  ASSIGN_OR_RETURN(const Pictures pictures, Prepare(arguments));
  const FeedPlan plan = MakeFeedPlan(pictures.taken_s, arguments.feed);
  const cv::Size size = pictures.side_by_side[0].size();
  ASSIGN_OR_RETURN(auto server, CameraServer::Start(size, arguments.port));
  const int port = server->port();
  std::printf("listening on 127.0.0.1:%d\n", port);
  std::fflush(stdout);
  RETURN_IF_ERROR(server->WaitForRobot(absl::Seconds(arguments.wait_s)));
  const absl::Time start = absl::Now();
  absl::Time plugged = start;
  bool unplugged = arguments.feed.unplug_s <= 0;
  for (const FedFrame& frame : plan.frames) {
    if (!unplugged && frame.given_s >= arguments.feed.unplug_at_s) {
      unplugged = true;
      absl::SleepFor(start + absl::Seconds(arguments.feed.unplug_at_s) - absl::Now());
      server.reset();
      std::printf("unplugged\n");
      absl::SleepFor(absl::Seconds(arguments.feed.unplug_s));
      ASSIGN_OR_RETURN(server, CameraServer::Start(size, port));
      plugged = absl::Now();
      std::printf("plugged in again\n");
      std::fflush(stdout);
    }
    absl::SleepFor(start + absl::Seconds(frame.given_s) - absl::Now());
    const absl::Duration stamp = start + absl::Seconds(frame.stamped_s) - plugged;
    RETURN_IF_ERROR(
        server->Give(pictures.side_by_side[frame.frame], std::max(stamp, absl::ZeroDuration())));
  }
  server->Finish();
  std::printf("fed %s\n", Describe(plan).c_str());
  return absl::OkStatus();
}

int Run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Plays a stereo recording as a camera for gst:tcpclientsrc");
  app.add_option("--source", arguments.source, "Recording or simulation")->required();
  app.add_option("--port", arguments.port, "Of 127.0.0.1; 0: any");
  app.add_option("--wait", arguments.wait_s, "Seconds to wait for the robot");
  app.add_option("--rate", arguments.rate_hz, "Frames a second; 0: the recording's times");
  app.add_option("--seed", arguments.feed.seed, "Of the disturbances");
  app.add_option("--drop", arguments.feed.dropped, "Share of frames that never come");
  app.add_option("--late", arguments.feed.late, "Share of frames that come late");
  app.add_option("--late-s", arguments.feed.late_s, "How late, at most");
  app.add_option("--double", arguments.feed.doubled, "Share of frames that come twice");
  app.add_option("--unplug-at", arguments.feed.unplug_at_s, "Seconds until it is unplugged");
  app.add_option("--unplug", arguments.feed.unplug_s, "For so many seconds; 0: never");
  app.add_flag("--hold", arguments.feed.hold, "The world stands still while it is unplugged");
  CLI11_PARSE(app, argc, argv);
  services::RegisterSimulatedSources();
  const absl::Status status = Feed(arguments);
  if (status.ok()) return 0;
  std::fprintf(stderr, "camera_feeder: %s\n", std::string(status.message()).c_str());
  return 1;
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) { return corbslam::tests::Run(argc, argv); }
