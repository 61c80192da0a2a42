#include "services/observe/event_log/robot_events.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace corbslam::services {

using client_agent::AgentEvents;
using client_agent::LinkEvent;
using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

using ::testing::ElementsAre;

constexpr LocalMapId kMap = {1};

class AllLines : public google::LogSink {
 public:
  AllLines() { google::AddLogSink(this); }
  ~AllLines() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity severity, const char*, const char*, int,
            const google::LogMessageTime&, const char* message, size_t length) override {
    lines.push_back(std::string(google::GetLogSeverityName(severity)) + " " +
                    std::string(message, length));
  }
  std::vector<std::string> lines;
};

TEST(RobotEventLogTest, FusionsDoingsAreLinesAndFramesAreNone) {
  AllLines sink;
  const auto events = std::make_shared<AgentEvents>();
  {
    const RobotEventLog log(events, {.mission = "lab", .agent = "alpha"});
    TrackingResult result;
    result.state = TrackingState::kTracking;
    result.local_map = kMap;
    events->NoteFrame(result, 1);
    events->NoteLink(LinkEvent::kMerged, kMap);
    events->NoteLink(LinkEvent::kSplit, kMap);
  }
  events->NoteLink(LinkEvent::kMissionDeleted, kMap);
  const std::string map = "local map " + ToString(kMap);
  EXPECT_THAT(sink.lines,
              ElementsAre("INFO mission=lab agent=alpha merged: " + map +
                              " lies in one frame with others' maps",
                          "WARNING mission=lab agent=alpha split: " + map +
                              " no longer lies in one frame with others' maps; a merge was taken "
                              "back"));
}

}  // namespace
}  // namespace corbslam::services
