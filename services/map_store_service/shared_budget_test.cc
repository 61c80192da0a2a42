// Tests that what others mapped comes to a robot at the pace that it asked for, as much of it as it
// asked for, and its acknowledgements at once.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "map_store/testing/sharing_mission.h"
#include "services/client/remote/remote_uplink.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

using testing::kMission;
using testing::SharedMirror;
using testing::TestAgent;

// Holds what comes down, and waits for it for at most 60 s.
class SharedNotes : public UplinkListener {
 public:
  void OnSessionOpened(const SessionGrant&) override {
    absl::MutexLock lock(&mutex_);
    open_ = true;
  }
  void OnAcknowledged(const Acknowledgement& acknowledgement) override {
    absl::MutexLock lock(&mutex_);
    acknowledged_ = acknowledgement.number;
  }
  void OnShared(SharedUpdate update) override {
    absl::MutexLock lock(&mutex_);
    mirror_.Apply(update);
  }
  void OnExactPlacesWanted() override {}
  void OnSessionClosed(const absl::Status&) override {}

  bool WaitForSession() {
    absl::MutexLock lock(&mutex_);
    return mutex_.AwaitWithTimeout(absl::Condition(&open_), kPatience);
  }
  bool WaitForAcknowledgement() { return WaitForBatch(1); }
  bool WaitForBatch(uint64_t number) {
    absl::MutexLock lock(&mutex_);
    const auto come = [this, number]()
                          ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return acknowledged_ >= number; };
    return mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience);
  }
  bool WaitForKeyframes(size_t count) {
    absl::MutexLock lock(&mutex_);
    const auto come = [this, count]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return mirror_.keyframes.size() >= count;
    };
    return mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience);
  }
  bool WaitForOwnPlaces(size_t count) {
    absl::MutexLock lock(&mutex_);
    const auto come = [this, count]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return mirror_.own.size() >= count;
    };
    return mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience);
  }
  SharedMirror mirror() {
    absl::MutexLock lock(&mutex_);
    return mirror_;
  }

 private:
  static constexpr absl::Duration kPatience = absl::Seconds(60);

  absl::Mutex mutex_;
  bool open_ ABSL_GUARDED_BY(mutex_) = false;
  uint64_t acknowledged_ ABSL_GUARDED_BY(mutex_) = 0;
  SharedMirror mirror_ ABSL_GUARDED_BY(mutex_);
};

class DelayNotes : public SyncObserver {
 public:
  void OnShareDelayed(const SessionAgent& agent, size_t bytes, absl::Duration waited) override {
    absl::MutexLock lock(&mutex_);
    EXPECT_EQ(agent.agent, "b");
    EXPECT_GT(waited, absl::ZeroDuration());
    bytes_ += bytes;
  }
  size_t bytes() {
    absl::MutexLock lock(&mutex_);
    return bytes_;
  }

 private:
  absl::Mutex mutex_;
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

// Agents a and b have mapped, and their maps are fused.
class SharedBudgetTest : public testing::SharingMission {
 protected:
  void SetUp() override {
    ASSERT_TRUE(a_.Stream(keyframes_of_a_).ok());
    ASSERT_TRUE(b_.Stream().ok());
    for (TestAgent* agent : {&a_, &b_}) store_.CloseSession(agent->session());
    Fuse();
    MapStoreServiceOptions options;
    options.observers = {&delays_};
    service_ = std::make_unique<MapStoreService>(&store_, options);
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  std::unique_ptr<Uplink> Open(uint64_t bytes_per_second, UplinkListener* listener) {
    return Open(b_, {}, bytes_per_second, listener);
  }
  std::unique_ptr<Uplink> Open(const TestAgent& agent, const ShareScope& scope,
                               uint64_t bytes_per_second, UplinkListener* listener) {
    auto uplink = MakeRemoteUplink(server_->InProcessChannel());
    SessionRequest request;
    request.mission = kMission;
    request.agent = agent.name();
    request.local_maps = {agent.local_map()};
    request.downlink_bytes_per_second = bytes_per_second;
    request.share = scope;
    uplink->Open(request, listener);
    return uplink;
  }
  bool IsUpToDate(const TestAgent& agent) {
    const auto agents = store_.ListAgents(kMission, {});
    for (const map_store::AgentInfo& info : agents->items) {
      if (info.name == agent.name()) return info.up_to_date;
    }
    return false;
  }

  size_t keyframes_of_a_ = 14;

  TestAgent a_{store_, kMission, "a", map_a_};
  TestAgent b_{store_, kMission, "b", map_b_};
  DelayNotes delays_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
};

TEST_F(SharedBudgetTest, ComesWithinTheBudgetToTheSameEnd) {
  SharedNotes fast;
  auto uplink = Open(0, &fast);
  ASSERT_TRUE(fast.WaitForKeyframes(11));
  const auto bytes = static_cast<double>(uplink->bytes_down());
  uplink->Close();
  EXPECT_EQ(delays_.bytes(), 0u);

  SharedNotes slow;
  // The updates take three seconds at this rate, as the first second's bytes are there at once.
  const double rate = bytes / 4;
  const absl::Time start = absl::Now();
  uplink = Open(static_cast<uint64_t>(rate), &slow);
  ASSERT_TRUE(slow.WaitForKeyframes(11));
  const double took_s = absl::ToDoubleSeconds(absl::Now() - start);
  // Only the last update may exceed the budget; it is paid for afterwards.
  EXPECT_LT(static_cast<double>(uplink->bytes_down()), rate * (1 + took_s) + bytes / 2);
  EXPECT_GT(delays_.bytes(), 0u);
  uplink->Close();
  const SharedMirror all = fast.mirror();
  const SharedMirror paced = slow.mirror();
  EXPECT_GT(paced.updates, all.updates);
  EXPECT_EQ(paced.own.size(), all.own.size());
  for (const auto& [id, keyframe] : all.keyframes) {
    ASSERT_TRUE(paced.keyframes.contains(id));
    EXPECT_EQ(paced.keyframes.at(id).points, keyframe.points);
  }
}

TEST_F(SharedBudgetTest, AcknowledgementsDoNotWaitForIt) {
  SharedNotes notes;
  // All updates would take minutes at this rate.
  const auto uplink = Open(1000, &notes);
  ASSERT_TRUE(notes.WaitForSession());
  MapUpdateBatch batch = b_.EmptyBatch();
  ASSERT_TRUE(uplink->Send(batch));
  EXPECT_TRUE(notes.WaitForAcknowledgement());
  EXPECT_LT(notes.mirror().keyframes.size(), 11u);
  // The stream ends although its timer is set.
  uplink->Close();
  SharedNotes again;
  const auto next = Open(0, &again);
  EXPECT_TRUE(again.WaitForKeyframes(11));
}

TEST_F(SharedBudgetTest, CorrectionsAreAllThatComesIfThatIsWanted) {
  SharedNotes notes;
  const auto uplink = Open(b_, {ShareMode::kCorrections}, 0, &notes);
  ASSERT_TRUE(notes.WaitForOwnPlaces(11));
  // The acknowledgement comes after all that was told before it.
  ASSERT_TRUE(uplink->Send(b_.EmptyBatch()));
  ASSERT_TRUE(notes.WaitForAcknowledgement());
  const SharedMirror mirror = notes.mirror();
  EXPECT_TRUE(mirror.keyframes.empty());
  EXPECT_TRUE(mirror.points.empty());
  EXPECT_TRUE(mirror.landmarks.empty());
  EXPECT_GT(mirror.revision, 0u);
}

TEST_F(SharedBudgetTest, NothingComesIfThatIsWanted) {
  SharedNotes notes;
  const auto uplink = Open(b_, {ShareMode::kNone}, 0, &notes);
  ASSERT_TRUE(notes.WaitForSession());
  ASSERT_TRUE(uplink->Send(b_.EmptyBatch()));
  ASSERT_TRUE(notes.WaitForAcknowledgement());
  EXPECT_TRUE(IsUpToDate(b_));
  EXPECT_EQ(notes.mirror().updates, 0);
  EXPECT_TRUE(notes.mirror().own.empty());
}

// A is still driving towards where B has been.
class NearbySyncTest : public SharedBudgetTest {
 protected:
  static constexpr ShareScope kClose = {ShareMode::kNearby, 3};

  NearbySyncTest() { keyframes_of_a_ = 10; }

  Eigen::Vector3d Centre(KeyframeId id) {
    return CameraCentre(store_.GetKeyframe(kMission, id)->camera_from_island.ToRigid());
  }
  // Adds B's settled keyframes that are near this one of A.
  void AddNear(uint32_t newest, std::set<KeyframeId>& near) {
    for (uint32_t i = 0; i < 11; ++i) {
      const double distance_m = (Centre(b_.Id(i)) - Centre(a_.Id(newest))).norm();
      if (distance_m <= kClose.radius_m) near.insert(b_.Id(i));
    }
  }
  static std::set<KeyframeId> Held(SharedNotes& notes) {
    std::set<KeyframeId> held;
    for (const auto& [id, keyframe] : notes.mirror().keyframes) held.insert(id);
    return held;
  }
};

TEST_F(NearbySyncTest, TheRobotsOwnBatchesBringWhatIsNearByThen) {
  SharedNotes notes;
  const auto uplink = Open(a_, kClose, 0, &notes);
  std::set<KeyframeId> near;
  AddNear(9, near);
  ASSERT_FALSE(near.empty());
  ASSERT_TRUE(notes.WaitForKeyframes(near.size()));
  EXPECT_EQ(Held(notes), near);
  const size_t first = near.size();
  for (uint32_t newest = 10; newest < 14; ++newest) {
    ASSERT_TRUE(uplink->Send(a_.NextBatch(1)));
    ASSERT_TRUE(notes.WaitForBatch(newest + 1));
    AddNear(newest, near);
    ASSERT_TRUE(notes.WaitForKeyframes(near.size())) << newest;
    EXPECT_EQ(Held(notes), near) << newest;
  }
  EXPECT_GT(near.size(), first + 2);
  EXPECT_LT(near.size(), 11u);
}

}  // namespace
}  // namespace corbslam::services
