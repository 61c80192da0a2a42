#include "client_agent/source_checks/judged_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/time/clock.h"
#include "client_agent/source_checks/testing/damage.h"
#include "client_agent/source_checks/testing/layered_scene.h"
#include "client_agent/source_checks/testing/sample_source.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Plays a scene, one frame each time it is asked, unless it is told to wait.
class SceneCamera : public FrameStream {
 public:
  SceneCamera(SampleSource source, const std::string& damage, double amount = 0)
      : source_(std::move(source)), read_(Damage(source_.read, damage, amount)) {}

  size_t end = 20;
  std::optional<size_t> waits_before;  // Gives nothing, until its deadline, before this frame.

  const SensorCalibration& calibration() const override { return source_.calibration; }
  std::optional<double> interval_s() const override { return 0.05; }
  absl::StatusOr<NextFrame> Next(absl::Time deadline) override {
    if (next_ == end) return StreamEnd();
    // What comes only when it is waited for is not there yet.
    if (deadline == absl::InfinitePast()) return NoFrameYet();
    if (next_ == waits_before) {
      if (deadline != absl::InfiniteFuture()) absl::SleepFor(deadline - absl::Now());
      return NoFrameYet();
    }
    StreamFrame frame;
    frame.frame = {next_, static_cast<int64_t>(next_) * 50'000'000, 0};
    auto images = read_(next_);
    if (!images.ok()) return images.status();
    frame.images = *std::move(images);
    frame.images.imu = {{frame.frame.timestamp_ns, {}, {}}};
    ++next_;
    return frame;
  }
  LeftOutFrames left_out() const override { return {}; }

 private:
  const SampleSource source_;
  const ReadFrame read_;
  size_t next_ = 0;
};

// Returns the numbers of the frames that come; the stream's error is `end`.
std::vector<size_t> Play(JudgedStream& stream, absl::Status& end) {
  std::vector<size_t> numbers;
  for (int i = 0; i < 100; ++i) {
    const auto next = stream.Next(absl::InfiniteFuture());
    end = next.status();
    if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) return numbers;
    if (const auto* frame = std::get_if<StreamFrame>(&*next)) {
      numbers.push_back(frame->frame.number);
    }
  }
  return numbers;
}

std::unique_ptr<SceneCamera> Scene(const std::string& damage, double amount = 0, size_t end = 6) {
  auto camera = std::make_unique<SceneCamera>(LayeredStereo(), damage, amount);
  camera->end = end;
  return camera;
}

TEST(JudgedStreamTest, ARightPairIsTakenFromItsThirdFrameOn) {
  JudgedStream stream(Scene(""), {});
  absl::Status end;
  EXPECT_THAT(Play(stream, end), ElementsAre(2, 3, 4, 5));
  EXPECT_TRUE(end.ok()) << end;
  EXPECT_EQ(stream.overtaken(), 2u);
  EXPECT_THAT(stream.findings(), IsEmpty());
}

TEST(JudgedStreamTest, WhatWasMeasuredBeforeItIsNotLost) {
  JudgedStream stream(Scene(""), {});
  while (true) {
    const auto next = stream.Next(absl::InfiniteFuture());
    ASSERT_TRUE(next.ok()) << next.status();
    const auto* const frame = std::get_if<StreamFrame>(&*next);
    if (frame == nullptr) continue;
    ASSERT_EQ(frame->frame.number, 2u);
    ASSERT_EQ(frame->images.imu.size(), 3u);
    EXPECT_EQ(frame->images.imu[0].timestamp_ns, 0);
    EXPECT_EQ(frame->images.imu[2].timestamp_ns, 100'000'000);
    break;
  }
}

TEST(JudgedStreamTest, AnExchangedPairGivesNoFrame) {
  JudgedStream stream(Scene("exchanged"), {});
  absl::Status end;
  EXPECT_THAT(Play(stream, end), IsEmpty());
  EXPECT_TRUE(absl::IsInvalidArgument(end)) << end;
  EXPECT_THAT(end.message(), HasSubstr("left and right are exchanged"));
  EXPECT_THAT(end.message(), HasSubstr("[pair-exchanged]"));
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(*stream.Next(absl::InfiniteFuture())));
}

TEST(JudgedStreamTest, ItIsTakenWhereItIsTrusted) {
  JudgedStream stream(Scene("exchanged"), {.trust_calibration = true});
  absl::Status end;
  EXPECT_THAT(Play(stream, end), ElementsAre(2, 3, 4, 5));
  ASSERT_EQ(stream.findings().size(), 1u);
  EXPECT_EQ(stream.findings()[0].code, "pair-exchanged");
  EXPECT_EQ(stream.findings()[0].level, FindingLevel::kWarning);
}

// Three frames do not show it: the stream begins, and ends when eight in a row do.
TEST(JudgedStreamTest, ALatePairEndsTheStreamByItsName) {
  absl::Status end;
  JudgedStream stream(Scene("late", 1, 20), {});
  Play(stream, end);
  EXPECT_TRUE(absl::IsInvalidArgument(end)) << end;
  EXPECT_THAT(end.message(), HasSubstr("the right camera is a frame or more behind"));
  EXPECT_THAT(end.message(), HasSubstr("[pair-late]"));
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(*stream.Next(absl::InfiniteFuture())));
  JudgedStream trusted(Scene("late", 1, 20), {.trust_calibration = true});
  EXPECT_FALSE(Play(trusted, end).empty());
  EXPECT_TRUE(end.ok()) << end;
  ASSERT_EQ(trusted.findings().size(), 1u);
  EXPECT_EQ(trusted.findings()[0].code, "pair-late");
}

TEST(JudgedStreamTest, TheSameCameraTwiceGivesNoFrame) {
  absl::Status end;
  JudgedStream stream(Scene("same"), {});
  EXPECT_THAT(Play(stream, end), IsEmpty());
  EXPECT_THAT(end.message(), HasSubstr("[pair-same-picture]"));
}

TEST(JudgedStreamTest, OtherFindingsAreWarningsUnlessSomebodyIsStrict) {
  absl::Status end;
  JudgedStream stream(Scene("rows", 6), {});
  EXPECT_EQ(Play(stream, end).size(), 4u);
  ASSERT_EQ(stream.findings().size(), 1u);
  EXPECT_EQ(stream.findings()[0].code, "pair-rows-apart");
  JudgedStream strict(Scene("rows", 6), {.strict = true});
  EXPECT_THAT(Play(strict, end), IsEmpty());
  EXPECT_THAT(end.message(), HasSubstr("[pair-rows-apart]"));
}

// A driver that waits for a pose before it gives the next frame.
TEST(JudgedStreamTest, AFrameIsNotHeldForLongAndIsJudgedAllTheSame) {
  auto camera = Scene("exchanged");
  SceneCamera& waiting = *camera;
  waiting.waits_before = 1;
  JudgedStream stream(std::move(camera), {});
  absl::StatusOr<NextFrame> next = NoFrameYet();
  const absl::Time asked = absl::Now();
  while (next.ok() && std::holds_alternative<NoFrameYet>(*next)) {
    next = stream.Next(absl::Now() + absl::Milliseconds(100));
  }
  EXPECT_GE(absl::Now() - asked, JudgedStream::kMaxWait);
  ASSERT_TRUE(next.ok());
  EXPECT_EQ(std::get<StreamFrame>(*next).frame.number, 0u);
  waiting.waits_before.reset();
  absl::Status end;
  EXPECT_THAT(Play(stream, end), ElementsAre(1));
  EXPECT_THAT(end.message(), HasSubstr("exchanged"));
}

TEST(JudgedStreamTest, AStartInTheDarkIsJudgedOnceItIsLight) {
  const SampleSource scene = LayeredStereo();
  const ReadFrame exchanged = Damage(scene.read, "exchanged");
  SampleSource dawn = scene;
  dawn.read = [exchanged](size_t frame) -> absl::StatusOr<SensorImages> {
    absl::StatusOr<SensorImages> images = exchanged(frame);
    if (images.ok() && frame < 4) images->grey = images->right = images->grey / 100;
    return images;
  };
  auto camera = std::make_unique<SceneCamera>(dawn, "");
  JudgedStream stream(std::move(camera), {});
  absl::Status end;
  EXPECT_THAT(Play(stream, end), ElementsAre(2));
  EXPECT_THAT(end.message(), HasSubstr("exchanged"));
}

TEST(JudgedStreamTest, ACameraThatEndsBeforeItIsJudgedGivesWhatItHas) {
  JudgedStream stream(Scene("", 0, 2), {});
  absl::Status end;
  EXPECT_THAT(Play(stream, end), ElementsAre(1));
}

TEST(JudgedStreamTest, DepthIsPlayedAsItComes) {
  auto camera = std::make_unique<SceneCamera>(LayeredRgbd(), "");
  camera->end = 2;
  JudgedStream stream(std::move(camera), {});
  absl::Status end;
  EXPECT_THAT(Play(stream, end), ElementsAre(0, 1));
}

}  // namespace
}  // namespace corbslam::client_agent
