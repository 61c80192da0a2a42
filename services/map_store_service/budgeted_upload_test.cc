// Tests a robot's map over a narrow link: recorder, budget, wire and store together.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {

using client_agent::FakeMapJobs;
using client_agent::GuardedMap;
using client_agent::StoreLink;
using client_agent::StoreLinkOptions;
using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kMap{0x11};
constexpr uint32_t kKeyframes = 20;
constexpr uint32_t kKeypoints = 200;
constexpr uint64_t kBytesPerSecond = 60000;

class BudgetedUploadTest : public ::testing::Test {
 protected:
  BudgetedUploadTest()
      : store_(MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr),
        service_(&store_),
        server_(*Server::Start("", {&service_})),
        uplink_(MakeRemoteUplink(server_->InProcessChannel())) {}
  ~BudgetedUploadTest() override {
    memory_.reset();
    uplink_.reset();
    server_->Shutdown(absl::ZeroDuration());
  }

  void StartRobot(uint64_t bytes_per_second) {
    StoreLinkOptions options;
    options.mission = "m";
    options.agent = "alpha";
    options.hold_newest_keyframes = 0;
    options.flush_interval = absl::Milliseconds(10);
    options.uplink_bytes_per_second = bytes_per_second;
    options.downlink_bytes_per_second = 1000;
    memory_ = std::make_unique<StoreLink>(options, uplink_.get(),
                                          [](const auto&) { return std::make_shared<Words>(); });
    memory_->Start();
    memory_->BeginLocalMap(map_, jobs_);
  }
  // Adds a keyframe and points that it and the one before see, and moves points that are there.
  void MapFrame(uint32_t index) {
    map_.Write([&](Map& map) { AddFrame(index, map); });
    memory_->AddTrackedFrame({index, {kMap, index}, {}});
  }
  void AddFrame(uint32_t index, Map& map) {
    const KeyframeId id{kMap, index};
    const KeyframeId before{kMap, index - 1};
    Keyframe keyframe;
    keyframe.payload = test_data::MakePayload(random_, id, kKeypoints);
    if (index > 0) keyframe.parent = before;
    map.AddKeyframe(std::move(keyframe));
    for (uint32_t p = 0; p < 30; ++p) {
      MapPoint point;
      point.id = {kMap, 30 * index + p};
      point.reference = id;
      point.position_in_map = {0.1 * p, 0.01 * index, 10};
      point.max_distance = 100;
      map.AddPoint(point);
      map.AddObservation(point.id, id, p);
      if (index > 0) map.AddObservation(point.id, before, 100 + p);
    }
    for (uint32_t k = 0; k < index; ++k) {
      map.SetPose({kMap, k}, {Eigen::Quaterniond::Identity(), {0.1 * index, 0.01 * k, 0}});
    }
  }

  // Expects the store to have what the robot has, as the robot has it.
  void ExpectWhole() {
    const Map whole = map_.Read([](const Map& map) { return map; });
    const auto info = store_.GetLocalMap("m", kMap);
    ASSERT_TRUE(info.ok()) << info.status();
    EXPECT_TRUE(info->closed);
    EXPECT_EQ(info->keyframes, whole.keyframes().size());
    EXPECT_EQ(info->map_points, whole.points().size());
    for (const auto& [id, keyframe] : whole.keyframes()) {
      const auto stored = store_.GetKeyframe("m", id);
      ASSERT_TRUE(stored.ok()) << stored.status();
      EXPECT_EQ(stored->parent, keyframe.parent);
      EXPECT_EQ(stored->keypoints, kKeypoints);
      EXPECT_EQ(stored->camera_from_local.translation, keyframe.camera_from_map.translation);
      size_t seen = 0;
      for (const MapPointId point : keyframe.points) seen += point.IsValid() ? 1 : 0;
      EXPECT_EQ(stored->observed_points, seen);
    }
  }

  MapStore store_;
  MapStoreService service_;
  const std::unique_ptr<Server> server_;
  std::unique_ptr<Uplink> uplink_;
  FakeMapJobs jobs_;
  GuardedMap map_{kMap};
  std::mt19937 random_{1};
  // Declared last, as it reads the map until it is destroyed.
  std::unique_ptr<StoreLink> memory_;
};

TEST_F(BudgetedUploadTest, TheMapIsWholeInTheEndAndTheBudgetIsKept) {
  const absl::Time start = absl::Now();
  StartRobot(kBytesPerSecond);
  for (uint32_t k = 0; k < kKeyframes; ++k) MapFrame(k);
  const absl::Status finished = memory_->Finish(absl::Seconds(120));
  ASSERT_TRUE(finished.ok()) << finished;
  const double took_s = absl::ToDoubleSeconds(absl::Now() - start);
  ExpectWhole();
  EXPECT_TRUE(memory_->upload().held_back.IsNothing());
  // More was sent than in a second, or there would have been nothing to hold back.
  EXPECT_GT(uplink_->bytes_up(), 2 * kBytesPerSecond);
  // The last batch's keyframe is paid for afterwards.
  EXPECT_LT(static_cast<double>(uplink_->bytes_up()), (1 + took_s) * kBytesPerSecond + 30000);
}

TEST_F(BudgetedUploadTest, WhoWaitsTooShortIsToldWhatIsLeft) {
  StartRobot(1000);
  for (uint32_t k = 0; k < kKeyframes; ++k) MapFrame(k);
  const absl::Status unfinished = memory_->Finish(absl::Seconds(1));
  ASSERT_TRUE(absl::IsDeadlineExceeded(unfinished)) << unfinished;
  EXPECT_THAT(unfinished.message(), HasSubstr("held back by a budget of 1000 bytes a second"));
  EXPECT_THAT(unfinished.message(), HasSubstr("600 points"));
}

TEST_F(BudgetedUploadTest, WithoutABudgetItIsAsBefore) {
  StartRobot(0);
  for (uint32_t k = 0; k < kKeyframes; ++k) MapFrame(k);
  const absl::Status finished = memory_->Finish(absl::Seconds(60));
  ASSERT_TRUE(finished.ok()) << finished;
  ExpectWhole();
}

}  // namespace
}  // namespace corbslam::services
