#include "services/programs/robot/left_out_log.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "services/programs/robot/testing/queued_stream.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class Lines : public google::LogSink {
 public:
  Lines() { google::AddLogSink(this); }
  ~Lines() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int, const google::LogMessageTime&,
            const char* message, size_t length) override {
    lines.emplace_back(message, length);
  }
  std::vector<std::string> lines;
};

TEST(LeftOutLogTest, ACameraIsToldOfEveryTenSecondsWithCounts) {
  Lines lines;
  QueuedStream camera;
  LeftOutLog log;
  const absl::Time start = absl::UnixEpoch() + absl::Hours(1);
  EXPECT_EQ(log.Tell(camera, start), 0u);
  // 25 pictures a second without a counterpart, for 25 seconds.
  for (size_t i = 1; i <= 625; ++i) {
    camera.left_out_frames = {i, "gst:a: pictures had no counterpart in time"};
    EXPECT_EQ(log.Tell(camera, start + i * absl::Milliseconds(40)), i);
  }
  EXPECT_THAT(lines.lines,
              ElementsAre(HasSubstr("1 of the camera's pictures are left out, 1 since"),
                          AllOf(HasSubstr("250 of the camera's"), HasSubstr("251 since"),
                                HasSubstr("no counterpart"), Not(HasSubstr("can't be read"))),
                          AllOf(HasSubstr("250 of the camera's"), HasSubstr("501 since"))));
}

TEST(LeftOutLogTest, EachFileOfARecordingIsToldOf) {
  Lines lines;
  QueuedStream recording;
  recording.live = false;
  LeftOutLog log;
  for (size_t i = 1; i <= 3; ++i) {
    recording.left_out_frames = {i, "000001.png is cut short"};
    log.Tell(recording, absl::UnixEpoch());
    log.Tell(recording, absl::UnixEpoch());
  }
  ASSERT_THAT(lines.lines, SizeIs(3));
  EXPECT_THAT(lines.lines[2], HasSubstr("can't be read is left out, 3 so far: 000001.png"));
}

TEST(LeftOutLogTest, TheEndOfARunIsInTheSourcesWords) {
  QueuedStream stream;
  EXPECT_THAT(DescribeLeftOut(stream, {9, "why"}), HasSubstr("9 of the camera's pictures"));
  stream.live = false;
  EXPECT_THAT(DescribeLeftOut(stream, {9, "why"}), HasSubstr("could not be read"));
}

}  // namespace
}  // namespace corbslam::services
