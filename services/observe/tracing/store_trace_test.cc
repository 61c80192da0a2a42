#include "services/observe/tracing/store_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/testing/small_mission.h"
#include "services/observe/tracing/testing/read_trace.h"

namespace corbslam::services {
namespace {

using ::testing::UnorderedElementsAre;

// Returns a path that only the running test uses.
std::string TracePath() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return absl::StrCat(::testing::TempDir(), "/", test->test_suite_name(), "_", test->name());
}

class StoreTraceTest : public ::testing::Test {
 protected:
  StoreTraceTest() : path_(TracePath()) {
    file_ = *TraceFile::Open(path_, "map_store");
    trace_ = std::make_unique<StoreTrace>(file_.get());
  }

  // Plays the mission's records, each as the journal and the streams tell of it.
  void Play(const absl::Status& status) {
    for (const map_store::JournalRecord& record : testing::MakeSmallMission()) {
      const auto* batch = std::get_if<map_store::BatchRecord>(&record);
      const SessionAgent agent{"lab", batch != nullptr ? batch->agent : ""};
      if (batch != nullptr) trace_->OnBatch(agent, *batch->batch);
      trace_->OnAppended("lab", record, absl::ZeroDuration(), status);
      if (batch != nullptr) {
        trace_->OnApplied(agent, *batch->batch, absl::ZeroDuration(), status);
      }
    }
  }

  std::vector<nlohmann::json> Events() {
    file_.reset();
    return *testing::ReadTrace(path_);
  }

  const std::string path_;
  std::unique_ptr<TraceFile> file_;
  std::unique_ptr<StoreTrace> trace_;
};

TEST_F(StoreTraceTest, KeyframesAreReceivedMadeDurablePlacedAndAdjustedOnce) {
  Play(absl::OkStatus());
  SharedUpdate update;
  auto payload = std::make_shared<KeyframePayload>();
  payload->id = {testing::kSmallMapA, 0};
  update.keyframes.push_back({payload, {}, {}, {}});
  trace_->OnShared({"lab", "b"}, update);
  const std::vector<nlohmann::json> events = Events();
  auto ways = testing::WaysOf(events);
  EXPECT_THAT(ways[TraceId({testing::kSmallMapA, 0})],
              UnorderedElementsAre(kReceived, kDurable, kPlaced, kAdjusted, kShared));
  int placed = 0;
  for (const nlohmann::json& event : events) {
    const bool is_first = event["args"].value("trace", "") == TraceId({testing::kSmallMapA, 0});
    if (!is_first || event["name"] != kPlaced) continue;
    ++placed;
    EXPECT_EQ(event["args"]["agent"], "a") << "whose it is";
    EXPECT_EQ(event["args"]["mission"], "lab");
  }
  EXPECT_EQ(placed, 1);
}

TEST_F(StoreTraceTest, WhatWasNotWrittenIsReceivedAndNoMore) {
  Play(absl::ResourceExhaustedError("the disk is full"));
  for (const auto& [trace, way] : testing::WaysOf(Events())) {
    EXPECT_THAT(way, UnorderedElementsAre(kReceived)) << trace;
  }
}

TEST_F(StoreTraceTest, ADeletedMissionBeginsAnew) {
  Play(absl::OkStatus());
  trace_->OnDeleted("lab");
  Play(absl::OkStatus());
  int placed = 0;
  for (const nlohmann::json& event : Events()) {
    placed +=
        event["name"] == kPlaced && event["args"]["trace"] == TraceId({testing::kSmallMapA, 0});
  }
  EXPECT_EQ(placed, 2);
}

}  // namespace
}  // namespace corbslam::services
