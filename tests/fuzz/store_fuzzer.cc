// Feeds batches made of choices, not of bytes: most of them pass the wire's checks, and reach the
// graph. Whatever comes of them, a store that reads the journal has the same.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/testing/recover_undamaged.h"
#include "tests/fuzz/live_store.h"

namespace corbslam::tests {

using map_store::KeyframeInfo;
using map_store::LocalMapInfo;
using map_store::MapStore;

namespace {

constexpr size_t kKeypoints = 6;

// Draws everything from few ids, so that references meet.
class BatchMaker {
 public:
  explicit BatchMaker(FuzzedDataProvider& input) : input_(input) {}

  MapUpdateBatch Make(LocalMapId local_map, uint64_t number) {
    MapUpdateBatch batch;
    batch.local_map = own_ = local_map;
    batch.number = number;
    if (number == 1) batch.cameras = {MakeCamera()};
    Fill(batch.full_keyframes, [this] { return MakeFullKeyframe(); });
    Fill(batch.full_points, [this] { return MakeFullPoint(); });
    Fill(batch.light_keyframes, [this] { return LightKeyframe{Own(), Pose(), Any()}; });
    Fill(batch.light_points, [this] { return LightMapPoint{OwnPoint(), Position()}; });
    Fill(batch.replacements, [this] { return PointReplacement{OwnPoint(), AnyPoint()}; });
    Fill(batch.observations, [this] { return MakeObservation(); });
    Fill(batch.removed_points, [this] { return OwnPoint(); });
    Fill(batch.removed_keyframes, [this] { return KeyframeRemoval{Own(), Any(), Pose()}; });
    Fill(batch.loop_edges, [this] {
      return LoopEdge{Own(), Any(), {1, Pose().rotation, Position()}};
    });
    Fill(batch.tracked_frames, [this] { return TrackedFrame{Time(), Any(), Pose()}; });
    Fill(batch.lost_frames_ns, [this] { return Time(); });
    batch.points_follow = input_.ConsumeBool();
    batch.closes_local_map = Rarely();
    return batch;
  }

 private:
  template <typename Item, typename Make>
  void Fill(std::vector<Item>& items, const Make& make) {
    const auto count = input_.ConsumeIntegralInRange<size_t>(0, 3);
    for (size_t i = 0; i < count; ++i) items.push_back(make());
  }

  bool Rarely() { return input_.ConsumeIntegralInRange(0, 63) == 63; }
  uint32_t Index() { return input_.ConsumeIntegralInRange<uint32_t>(0, 11); }
  LocalMapId Map() {
    return Rarely() ? LocalMapId() : LocalMapId{input_.PickValueInArray<uint64_t>({1, 2, 3})};
  }
  KeyframeId Own() { return {Rarely() ? Map() : own_, Index()}; }
  MapPointId OwnPoint() { return {Rarely() ? Map() : own_, Index()}; }
  KeyframeId Any() {
    if (input_.ConsumeBool()) return Own();
    return input_.ConsumeBool() ? KeyframeId() : KeyframeId{Map(), Index()};
  }
  MapPointId AnyPoint() { return input_.ConsumeBool() ? OwnPoint() : MapPointId{Map(), Index()}; }
  int64_t Time() {
    return Rarely() ? input_.ConsumeIntegral<int64_t>() : input_.ConsumeIntegralInRange(0, 50);
  }
  double Number() {
    if (!Rarely()) return input_.ConsumeIntegralInRange(-8, 8);
    return input_.PickValueInArray({std::numeric_limits<double>::quiet_NaN(),
                                    std::numeric_limits<double>::infinity(), 1e300, 1e-300, 9e7});
  }
  Eigen::Vector3d Position() {
    Eigen::Vector3d position;
    for (double& value : position) value = Number();
    return position;
  }
  Rigid3d Pose() {
    Eigen::Quaterniond rotation(1 + Number() * Number(), Number(), 0, 0);
    if (!Rarely()) rotation.normalize();
    return {rotation, Position()};
  }
  static std::shared_ptr<const Camera> MakeCamera() {
    return std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4});
  }

  FullKeyframe MakeFullKeyframe() {
    Features features;
    features.keypoints.resize(Rarely() ? kKeypoints - 1 : kKeypoints);
    features.descriptors.resize(Rarely() ? kKeypoints - 1 : features.keypoints.size());
    features.keypoints[0].disparity_px = static_cast<float>(Number());
    auto payload = std::make_shared<KeyframePayload>();
    payload->id = Own();
    payload->timestamp_ns = Time();
    payload->camera_index = Rarely() ? 1 : 0;
    payload->features = std::move(features);
    return {payload, Pose(), Any()};
  }
  FullMapPoint MakeFullPoint() {
    FullMapPoint point;
    point.id = OwnPoint();
    point.position_in_local = Position();
    point.reference = Any();
    point.max_distance = Number();
    return point;
  }
  ObservationChange MakeObservation() {
    return {
        input_.ConsumeBool() ? ObservationChange::Kind::kAdded : ObservationChange::Kind::kRemoved,
        AnyPoint(), Own(), input_.ConsumeIntegralInRange<uint32_t>(0, kKeypoints)};
  }

  FuzzedDataProvider& input_;
  LocalMapId own_;
};

// Describes what look-ups say of the local layer.
std::string DescribeMap(const MapStore& store) {
  std::string text;
  const auto maps = store.ListLocalMaps("m", {});
  for (const LocalMapInfo& map : maps->items) {
    absl::StrAppend(&text, ToString(map.id), " ", map.agent, " ", map.closed, " ", map.last_batch,
                    " ", map.settled_keyframes, " ", map.map_points, " ", map.tracked_frames, " ",
                    map.lost_frames, " ", map.parked_references, "\n");
  }
  const auto keyframes = store.ListKeyframes("m", {}, {});
  for (const KeyframeInfo& keyframe : keyframes->items) {
    const Eigen::Vector3d& at = keyframe.camera_from_local.translation;
    absl::StrAppend(&text, ToString(keyframe.id), " ", ToString(keyframe.parent), " ",
                    keyframe.observed_points, " ", keyframe.keypoints, " ",
                    keyframe.payload->features.keypoints[0].disparity_px, " ", at.x(), " ", at.y(),
                    " ", at.z(), "\n");
  }
  return text;
}

struct Robot {
  uint64_t session = 0;
  uint64_t applied = 0;
  LocalMapId local_map;
};

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  FuzzedDataProvider input(data, size);
  const auto journal = std::make_shared<testing::JournalBytes>();
  auto store = MakeLiveStore(journal);
  std::vector<Robot> robots(2);
  for (size_t i = 0; i < robots.size(); ++i) {
    SessionRequest request;
    request.mission = "m";
    request.agent = i == 0 ? "a" : "b";
    robots[i].session = store->OpenSession(request)->session_id;
    robots[i].local_map = {i + 1};
  }
  BatchMaker maker(input);
  while (input.remaining_bytes() > 0) {
    Robot& robot = robots[input.ConsumeBool() ? 1 : 0];
    const MapUpdateBatch batch = maker.Make(robot.local_map, robot.applied + 1);
    if (store->Apply(robot.session, batch).ok()) ++robot.applied;
    if (input.ConsumeBool()) (void)store->NextShared(robot.session, 5000);
  }
  LookAtEverything(*store);
  const std::string map = DescribeMap(*store);
  for (const bool wants_snapshot : {true, false}) {
    journal->wants_snapshot = wants_snapshot;
    store = MakeLiveStore(journal);
    if (!testing::RecoverUndamaged(*store).ok() || DescribeMap(*store) != map) std::abort();
    // Writes the snapshot, and has it read.
    store->RunFusionUntilIdle(journal->mission).IgnoreError();
  }
  return 0;
}
