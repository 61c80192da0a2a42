#include "services/tool/replay/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/agent/agent_orders.h"
#include "client_agent/source/recorded_sequence.h"
#include "services/programs/default_vocabulary.h"
#include "services/programs/recording/frame_recorder.h"
#include "services/programs/recording/recording_files.h"
#include "services/simulated_source/simulated_source.h"
#include "services/testing/test_path.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::AgentOrders;
using client_agent::OpenSource;
using client_agent::TrackingResult;

namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kFeatures = 800;
constexpr int kFrames = 12;

// Records a short simulated drive; from frame 8 on it is told to map anew.
class ReplayTest : public ::testing::Test {
 protected:
  void SetUp() override {
    RegisterSimulatedSources();
    folder_ = TestPath("recording");
    std::filesystem::remove_all(folder_);
  }

  // Called before each frame is tracked.
  using Before = std::function<void(int frame, Agent& agent, AgentOrders& orders)>;
  static void MapAnew(int frame, Agent& agent, AgentOrders& /*orders*/) {
    if (frame == 8) agent.BeginLocalMap();
  }

  void Record(const std::string& pace, const Before& before = MapAnew) {
    const auto source = OpenSource(
        absl::StrCat("sim:city?seed=3&length=120&picture_scale=0.5&frames=0:", kFrames - 1));
    ASSERT_TRUE(source.ok()) << source.status();
    const auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    AgentOptions options;
    options.seed = 5;
    options.deterministic = true;
    options.orders = std::make_shared<AgentOrders>();
    options.sensor.orb.features = kFeatures;
    const auto agent = Agent::Create(options, (*source)->calibration(), *vocabulary, nullptr);
    ASSERT_TRUE(agent.ok()) << agent.status();
    RecordingHead head;
    head.version = "test";
    head.flags = {options.mission,
                  options.name,
                  options.seed,
                  kFeatures,
                  1,
                  pace,
                  false,
                  (*vocabulary)->fingerprint()};
    head.calibration = (*source)->calibration();
    RecorderOptions recorder_options;
    recorder_options.waits = true;
    recorder_options.least_free_bytes = 0;
    const auto recorder = FrameRecorder::Start(folder_, head, recorder_options);
    ASSERT_TRUE(recorder.ok()) << recorder.status();
    const auto recorded = (*recorder)->Watch(agent->get(), options.orders.get());
    Drive(**source, *recorded, **recorder, *options.orders, before);
    ASSERT_TRUE((*recorder)->Finish().ok());
  }
  Recording Read() {
    absl::StatusOr<Recording> recording = ReadRecording(folder_);
    EXPECT_TRUE(recording.ok()) << recording.status();
    return *std::move(recording);
  }
  Replayed Play(const Recording& recording) {
    absl::StatusOr<Replayed> replayed = Replay(recording, {});
    EXPECT_TRUE(replayed.ok()) << replayed.status();
    return *std::move(replayed);
  }

  std::string folder_;

 private:
  static void Drive(client_agent::RecordedSequence& source, Agent& agent, FrameRecorder& recorder,
                    AgentOrders& orders, const Before& before) {
    for (int i = 0; i < kFrames; ++i) {
      const auto images = source.NextImages();
      ASSERT_TRUE(images.ok() && images->has_value()) << images.status();
      before(i, agent, orders);
      const absl::StatusOr<TrackingResult> result = agent.Track(**images);
      ASSERT_TRUE(result.ok()) << result.status();
      recorder.OnResult(*result, 0);
    }
  }
};

TEST_F(ReplayTest, ARobotThatOnlyLocalisedIsNotPlayedAsOneThatMaps) {
  Record("step");
  Recording recording = Read();
  EXPECT_FALSE(recording.head.flags.localise_only);
  recording.head.flags.localise_only = true;
  const auto head = ParseHead(FormatHead(recording.head));
  ASSERT_TRUE(head.ok()) << head.status();
  EXPECT_EQ(head->flags, recording.head.flags);
  const absl::Status refused = Replay(recording, {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()),
              AllOf(HasSubstr("the robot made no map"), HasSubstr("--localise-only")));
}

TEST_F(ReplayTest, APictureThatWasReplacedIsSaidAndLeftOut) {
  Record("step");
  const Recording recording = Read();
  const auto of_frame = [&](size_t frame) {
    return PicturePaths(folder_, recording.kind(), recording.frames[frame].line.pictures)[0];
  };
  std::filesystem::copy_file(of_frame(2), of_frame(5),
                             std::filesystem::copy_options::overwrite_existing);
  const Replayed replayed = Play(recording);
  EXPECT_FALSE(replayed.results[5].has_value());
  EXPECT_THAT(ReasonsToDiffer(recording, replayed, "test"),
              Contains(HasSubstr(of_frame(5) + ": holds another picture than was recorded")));
}

TEST_F(ReplayTest, WhatWasRecordedInLockstepComesBackToTheDigit) {
  Record("step");
  const Recording recording = Read();
  ASSERT_EQ(recording.frames.size(), size_t{kFrames});
  const Replayed replayed = Play(recording);
  const ReplayComparison comparison = CompareResults(ResultsOf(recording), replayed.results);
  EXPECT_EQ(comparison.compared, size_t{kFrames});
  EXPECT_TRUE(comparison.AllEqual()) << FormatComparison(comparison);
  EXPECT_GE(comparison.recorded_events.size(), 2u) << "the second local map";
  EXPECT_THAT(ReasonsToDiffer(recording, replayed, "test"), IsEmpty());
  EXPECT_GE(replayed.agent->GetStatus().tracked, kFrames / 2);
}

// A pause takes keyframes away, a mask takes features, an order for a new map changes the map.
TEST_F(ReplayTest, OrdersAreGivenAgainToTheDigit) {
  Record("step", [](int frame, Agent& /*agent*/, AgentOrders& orders) {
    absl::Status given;
    if (frame == 2) given = orders.PauseMapping(true);
    if (frame == 5) given = orders.PauseMapping(false);
    if (frame == 7) given = orders.OpenLocalMap();
    if (frame == 9) {
      cv::Mat mask(188, 621, CV_8UC1, 255.0);
      mask.rowRange(100, 188) = 0.0;
      given = orders.SetMask(mask);
    }
    if (frame == 11) given = orders.SetMask(PictureMask());
    EXPECT_TRUE(given.ok()) << frame << ": " << given;
  });
  Recording recording = Read();
  ASSERT_EQ(recording.frames.size(), size_t{kFrames});
  EXPECT_EQ(recording.frames[2].orders, (OrdersLine{2, true, false}));
  EXPECT_FALSE(recording.frames[3].orders.has_value());
  EXPECT_EQ(recording.frames[7].orders, (OrdersLine{7, false, true}));
  ASSERT_TRUE(recording.frames[9].orders.has_value());
  const std::optional<uint32_t> mask_checksum = recording.frames[9].orders->mask_checksum;
  EXPECT_TRUE(mask_checksum.has_value());
  EXPECT_EQ(recording.frames[9].orders, (OrdersLine{9, false, false, true, mask_checksum}));
  EXPECT_EQ(recording.frames[11].orders, (OrdersLine{11, false, false, false}));
  const Replayed replayed = Play(recording);
  EXPECT_THAT(ReasonsToDiffer(recording, replayed, "test"), IsEmpty());
  const ReplayComparison comparison = CompareResults(ResultsOf(recording), replayed.results);
  EXPECT_TRUE(comparison.AllEqual()) << FormatComparison(comparison);
  EXPECT_EQ(replayed.agent->GetStatus().local_maps, 2);
  // Without them it is another run.
  for (RecordedFrame& frame : recording.frames) frame.orders.reset();
  EXPECT_FALSE(CompareResults(ResultsOf(recording), Play(recording).results).AllEqual());
}

TEST_F(ReplayTest, AnOrderedMaskThatIsGoneIsSaid) {
  Record("step", [](int frame, Agent& /*agent*/, AgentOrders& orders) {
    if (frame != 3) return;
    EXPECT_TRUE(orders.SetMask(cv::Mat(188, 621, CV_8UC1, 255.0)).ok());
  });
  const Recording recording = Read();
  std::filesystem::remove(folder_ + "/masks/3.png");
  EXPECT_THAT(ReasonsToDiffer(recording, Play(recording), "test"), Contains(HasSubstr("frame 3")));
}

TEST_F(ReplayTest, AnotherSeedIsAnotherRun) {
  Record("step");
  Recording recording = Read();
  recording.head.flags.seed = 6;
  EXPECT_FALSE(CompareResults(ResultsOf(recording), Play(recording).results).AllEqual());
}

TEST_F(ReplayTest, AFrameThatIsGoneIsSaidAndTheRestPlayed) {
  Record("step");
  const Recording recording = Read();
  std::filesystem::remove(folder_ + "/mav0/cam1/data/" + recording.frames[3].line.pictures);
  const Replayed replayed = Play(recording);
  EXPECT_FALSE(replayed.results[3].has_value());
  EXPECT_TRUE(replayed.results[4].has_value());
  EXPECT_THAT(ReasonsToDiffer(recording, replayed, "test"), Contains(HasSubstr("frame 3")));
}

TEST_F(ReplayTest, NamesWhatExplainsADifference) {
  Record("max");
  Recording recording = Read();
  recording.head.flags.joined = true;
  const auto reasons = ReasonsToDiffer(recording, Replayed(), "another program");
  EXPECT_THAT(reasons, Contains(HasSubstr("--pace max")));
  EXPECT_THAT(reasons, Contains(HasSubstr("map store")));
  EXPECT_THAT(reasons, Contains(HasSubstr("this is another program")));
}

}  // namespace
}  // namespace corbslam::services
