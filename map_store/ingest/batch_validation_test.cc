// Tests batches with one thing wrong each: whether they are refused, with which status, and naming
// what.
#include "map_store/ingest/batch_validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kMap{0xa};
constexpr LocalMapId kOther{0xb};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr KeyframeId Kf(uint32_t index) { return {kMap, index}; }
constexpr MapPointId Pt(uint32_t index) { return {kMap, index}; }

MapStoreOptions Options() {
  MapStoreOptions options;
  options.max_keypoints_per_keyframe = 10;
  options.max_items_per_batch = 50;
  options.max_frames_per_batch = 60;
  options.max_pair_steps_per_batch = 8;
  options.max_parked_references = 2;
  options.max_cameras_per_local_map = 2;
  return options;
}

std::shared_ptr<const KeyframePayload> MakePayload(uint32_t index, size_t keypoints) {
  auto payload = std::make_shared<KeyframePayload>();
  payload->id = Kf(index);
  payload->timestamp_ns = 100 * index;
  payload->features.keypoints.resize(keypoints);
  payload->features.descriptors.resize(keypoints);
  return payload;
}

// Returns a batch with something good in every field.
MapUpdateBatch Good() {
  MapUpdateBatch batch;
  batch.local_map = kMap;
  batch.number = 1;
  batch.cameras = {std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})};
  batch.full_keyframes = {{MakePayload(0, 4), Rigid3d::Identity(), {}},
                          {MakePayload(1, 4), Rigid3d::Identity(), Kf(0)}};
  FullMapPoint point;
  point.id = Pt(0);
  point.reference = Kf(0);
  point.normal_in_local = {0, 0, 1};
  point.min_distance = 1;
  point.max_distance = 2;
  batch.full_points = {point};
  batch.light_keyframes = {{Kf(1), Rigid3d::Identity(), Kf(0)}};
  batch.light_points = {{Pt(0), {1, 2, 3}}};
  batch.replacements = {{Pt(5), {kOther, 6}}};
  batch.observations = {{ObservationChange::Kind::kAdded, Pt(0), Kf(0), 0}};
  batch.removed_points = {Pt(7)};
  batch.removed_keyframes = {{Kf(8), Kf(0), Rigid3d::Identity()}};
  batch.loop_edges = {{Kf(0), {kOther, 1}, Similarity3d::Identity()}};
  batch.tracked_frames = {{5, Kf(0), Rigid3d::Identity()}};
  batch.lost_frames_ns = {6};
  return batch;
}

// Puts a copy in the payload's place, and returns it to be changed.
KeyframePayload& Payload(MapUpdateBatch& batch, size_t i) {
  auto copy = std::make_shared<KeyframePayload>(*batch.full_keyframes[i].payload);
  KeyframePayload& payload = *copy;
  batch.full_keyframes[i].payload = std::move(copy);
  return payload;
}
void ReplaceCamera(MapUpdateBatch& batch, const std::function<void(Camera&)>& change) {
  Camera camera = *batch.cameras[0];
  change(camera);
  batch.cameras[0] = std::make_shared<const Camera>(camera);
}

struct Case {
  std::string name;
  std::function<void(MapUpdateBatch&)> mutate;
  absl::StatusCode code = absl::StatusCode::kInvalidArgument;
  // Parts of the message.
  std::vector<std::string> says;
};

using B = MapUpdateBatch&;
constexpr auto kDenied = absl::StatusCode::kPermissionDenied;
constexpr auto kTooMuch = absl::StatusCode::kResourceExhausted;
constexpr auto kBad = absl::StatusCode::kInvalidArgument;

std::vector<Case> CameraCases() {
  return {
      {"NoCamera", [](B b) { b.cameras.clear(); }, kBad, {"000000000000000a:0", "camera 0"}},
      {"NullCamera", [](B b) { b.cameras[0] = nullptr; }, kBad, {"camera 0"}},
      {"NoFocalLength",
       [](B b) { ReplaceCamera(b, [](Camera& c) { c.fx_px = 0; }); },
       kBad,
       {"fx_px is 0"}},
      {"NanFocalLength",
       [](B b) { ReplaceCamera(b, [](Camera& c) { c.fy_px = kNan; }); },
       kBad,
       {"fy_px is nan"}},
      {"NoWidth",
       [](B b) { ReplaceCamera(b, [](Camera& c) { c.width_px = 0; }); },
       kBad,
       {"width_px is 0"}},
      {"HugeHeight",
       [](B b) { ReplaceCamera(b, [](Camera& c) { c.height_px = 1 << 20; }); },
       kBad,
       {"height_px is"}},
      {"NegativeBaseline",
       [](B b) { ReplaceCamera(b, [](Camera& c) { c.baseline_m = -1; }); },
       kBad,
       {"baseline_m is -1"}},
      {"CameraGap", [](B b) { b.first_camera_index = 1; }, kBad, {"cameras from index 1"}},
      {"TooManyCameras", [](B b) { b.cameras.resize(3, b.cameras[0]); }, kBad, {"limit is 2"}},
      {"OtherCamera",
       [](B b) { Payload(b, 0).camera = std::make_shared<const Camera>(); },
       kBad,
       {"another camera"}},
  };
}

std::vector<Case> KeyframeCases() {
  return {
      {"NoLocalMap", [](B b) { b.local_map = {}; }, kBad, {"no local map"}},
      {"NoPayload", [](B b) { b.full_keyframes[0].payload = nullptr; }, kBad, {"payload"}},
      {"NoId", [](B b) { Payload(b, 0).id = {}; }, kBad, {"full keyframe: no id"}},
      {"SomebodyElses",
       [](B b) {
         Payload(b, 0).id = {kOther, 0};
       },
       kDenied,
       {"000000000000000b:0"}},
      {"Twice",
       [](B b) { b.full_keyframes.push_back(b.full_keyframes[0]); },
       kBad,
       {"000000000000000a:0 comes twice"}},
      {"LightTwice",
       [](B b) { b.light_keyframes.assign(2, b.light_keyframes[0]); },
       kBad,
       {"light keyframe", "comes twice"}},
      {"NanPose",
       [](B b) { b.full_keyframes[1].camera_from_local.translation.x() = kNan; },
       kBad,
       {"000000000000000a:1", "camera_from_local is nan"}},
      {"FarPose",
       [](B b) { b.full_keyframes[1].camera_from_local.translation.z() = 1e9; },
       kBad,
       {"1e+09", "1e+08"}},
      {"NoRotation",
       [](B b) { b.full_keyframes[1].camera_from_local.rotation.coeffs().setZero(); },
       kBad,
       {"length of the quaternion", "is 0"}},
      {"LongRotation",
       [](B b) { b.light_keyframes[0].camera_from_local.rotation.coeffs() *= 1.1; },
       kBad,
       {"light keyframe 000000000000000a:1", "length of the quaternion"}},
      {"OwnParent", [](B b) { b.full_keyframes[1].parent = Kf(1); }, kBad, {"its own parent"}},
      {"OwnParentLight", [](B b) { b.light_keyframes[0].parent = Kf(1); }, kBad, {"own parent"}},
      {"HalfAParent",
       [](B b) {
         b.full_keyframes[1].parent.local_map = kMap;
         b.full_keyframes[1].parent.index = KeyframeId::kNoIndex;
       },
       kBad,
       {"half a parent"}},
      {"EarlyTime", [](B b) { Payload(b, 1).timestamp_ns = -1; }, kBad, {"timestamp_ns is -1"}},
      {"LateTime",
       [](B b) { Payload(b, 1).timestamp_ns = std::numeric_limits<int64_t>::max(); },
       kBad,
       {"timestamp_ns is 9223372036854775807"}},
      {"LightSomebodyElses",
       [](B b) {
         b.light_keyframes[0].id = {kOther, 1};
       },
       kDenied,
       {}},
      {"RemovedSomebodyElses",
       [](B b) {
         b.removed_keyframes[0].id = {kOther, 1};
       },
       kDenied,
       {}},
      {"RemovedOwnParent",
       [](B b) { b.removed_keyframes[0].parent = Kf(8); },
       kBad,
       {"own parent"}},
      {"RemovedNan",
       [](B b) { b.removed_keyframes[0].parent_from_removed.translation.y() = kInfinite; },
       kBad,
       {"parent_from_removed is inf"}},
  };
}

std::vector<Case> FeatureCases() {
  return {
      {"TooManyKeypoints",
       [](B b) { b.full_keyframes[0].payload = MakePayload(0, 11); },
       kTooMuch,
       {"000000000000000a:0 has 11 keypoints", "limit is 10"}},
      {"DescriptorsMissing",
       [](B b) { Payload(b, 0).features.descriptors.pop_back(); },
       kBad,
       {"4 keypoints but 3 descriptors"}},
      {"NanPixel",
       [](B b) { Payload(b, 0).features.keypoints[2].x_px = std::nanf(""); },
       kBad,
       {"x_px of keypoint 2 is nan"}},
      {"FarPixel",
       [](B b) { Payload(b, 0).features.keypoints[2].y_px = 5000; },
       kBad,
       {"y_px of keypoint 2 is 5000", "960"}},
      {"Disparity",
       [](B b) {
         Payload(b, 0).features.keypoints[1].disparity_px = static_cast<float>(kInfinite);
       },
       kBad,
       {"disparity_px of keypoint 1 is inf"}},
      {"Angle",
       [](B b) { Payload(b, 0).features.keypoints[0].angle_rad = 100; },
       kBad,
       {"angle_rad of keypoint 0 is 100"}},
      {"Octave",
       [](B b) { Payload(b, 0).features.keypoints[0].octave = 8; },
       kBad,
       {"octave of keypoint 0 is 8"}},
  };
}

std::vector<Case> PointCases() {
  return {
      {"PointSomebodyElses",
       [](B b) {
         b.full_points[0].id = {kOther, 0};
       },
       kDenied,
       {}},
      {"PointTwice", [](B b) { b.full_points.push_back(b.full_points[0]); }, kBad, {"twice"}},
      {"NanPosition",
       [](B b) { b.full_points[0].position_in_local.y() = kNan; },
       kBad,
       {"full map point 000000000000000a:0: position is nan"}},
      {"LongNormal",
       [](B b) { b.full_points[0].normal_in_local *= 2; },
       kBad,
       {"length of the normal is 2"}},
      {"NanNormal", [](B b) { b.full_points[0].normal_in_local.x() = kNan; }, kBad, {"normal"}},
      {"NegativeDistance",
       [](B b) { b.full_points[0].min_distance = -1; },
       kBad,
       {"min_distance is -1"}},
      {"DistancesTurned",
       [](B b) { b.full_points[0].max_distance = 0.5; },
       kBad,
       {"max_distance is 0.5"}},
      {"InfiniteDistance", [](B b) { b.full_points[0].max_distance = kInfinite; }, kBad, {"inf"}},
      {"LightPointTwice",
       [](B b) { b.light_points.assign(2, b.light_points[0]); },
       kBad,
       {"light map point", "comes twice"}},
      {"LightNan",
       [](B b) { b.light_points[0].position_in_local.x() = kNan; },
       kBad,
       {"light map point"}},
      {"LightPointSomebodyElses",
       [](B b) {
         b.light_points[0].id = {kOther, 0};
       },
       kDenied,
       {}},
      {"ReplacedSomebodyElses",
       [](B b) {
         b.replacements[0].replaced = {kOther, 1};
       },
       kDenied,
       {}},
      {"ReplacesItself", [](B b) { b.replacements[0].survivor = Pt(5); }, kBad, {"itself"}},
      {"NoSurvivor", [](B b) { b.replacements[0].survivor = {}; }, kBad, {"survivor"}},
      {"RemovedPointSomebodyElses",
       [](B b) {
         b.removed_points[0] = {kOther, 1};
       },
       kDenied,
       {}},
  };
}

std::vector<Case> GraphCases() {
  return {
      {"KeypointOutOfRange",
       [](B b) { b.observations[0].keypoint = 4; },
       kBad,
       {"keypoint 4 of keyframe 000000000000000a:0, which has 4"}},
      {"UnknownKind",
       [](B b) { b.observations[0].kind = static_cast<ObservationChange::Kind>(7); },
       kBad,
       {"of kind 7"}},
      {"ObserverSomebodyElses",
       [](B b) {
         b.observations[0].keyframe = {kOther, 0};
       },
       kDenied,
       {}},
      {"NoPoint", [](B b) { b.observations[0].point = {}; }, kBad, {"observed point: no id"}},
      {"LoopToItself", [](B b) { b.loop_edges[0].b = Kf(0); }, kBad, {"to itself"}},
      {"LoopSomebodyElses",
       [](B b) {
         b.loop_edges[0].a = {kOther, 2};
       },
       kDenied,
       {}},
      {"LoopScale", [](B b) { b.loop_edges[0].b_from_a.scale = 0; }, kBad, {"scale is 0"}},
      {"LoopNan", [](B b) { b.loop_edges[0].b_from_a.translation.x() = kNan; }, kBad, {"nan"}},
      {"FrameNoReference", [](B b) { b.tracked_frames[0].reference = {}; }, kBad, {"no id"}},
      {"FrameTime", [](B b) { b.tracked_frames[0].timestamp_ns = -5; }, kBad, {"is -5"}},
      {"FramePose",
       [](B b) { b.tracked_frames[0].reference_from_camera.translation.x() = kNan; },
       kBad,
       {"reference_from_camera is nan"}},
      {"LostTime", [](B b) { b.lost_frames_ns[0] = -7; }, kBad, {"lost frame", "is -7"}},
      {"TooManyItems",
       [](B b) { b.removed_points.resize(100, Pt(0)); },
       kTooMuch,
       {"items", "limit is 50"}},
      {"TooManyFrames",
       [](B b) { b.lost_frames_ns.resize(100, 1); },
       kTooMuch,
       {"frames", "limit is 60"}},
      {"TooManySteps",
       [](B b) {
         for (int i = 0; i < 6; ++i) {
           for (const auto kind :
                {ObservationChange::Kind::kAdded, ObservationChange::Kind::kRemoved}) {
             b.observations.push_back({kind, Pt(0), Kf(0), 1});
           }
         }
       },
       kTooMuch,
       {"steps", "limit is 8"}},
      {"TooManyParkedObservations",
       [](B b) {
         b.observations.resize(4, {ObservationChange::Kind::kAdded, Pt(90), Kf(0), 1});
       },
       kTooMuch,
       {"3 references of local map 000000000000000a", "limit is 2"}},
      {"TooManyParkedEdges",
       [](B b) {
         b.loop_edges.resize(4, {Kf(0), Kf(77), Similarity3d::Identity()});
       },
       kTooMuch,
       {"limit is 2"}},
      {"TooManyParkedParents",
       [](B b) {
         b.light_keyframes.resize(4, {Kf(1), Rigid3d::Identity(), Kf(77)});
       },
       kTooMuch,
       {"limit is 2"}},
  };
}

class BatchValidationTest : public ::testing::TestWithParam<Case> {};

TEST_P(BatchValidationTest, RefusesAndSaysWhy) {
  MapUpdateBatch batch = Good();
  ASSERT_TRUE(ValidateBatch(nullptr, batch, Options()).ok());
  GetParam().mutate(batch);
  const absl::Status status = ValidateBatch(nullptr, batch, Options());
  EXPECT_EQ(status.code(), GetParam().code) << status;
  for (const std::string& part : GetParam().says) {
    EXPECT_THAT(std::string(status.message()), HasSubstr(part));
  }
}

std::string Name(const ::testing::TestParamInfo<Case>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Cameras, BatchValidationTest, ::testing::ValuesIn(CameraCases()), Name);
INSTANTIATE_TEST_SUITE_P(Keyframes, BatchValidationTest, ::testing::ValuesIn(KeyframeCases()),
                         Name);
INSTANTIATE_TEST_SUITE_P(Features, BatchValidationTest, ::testing::ValuesIn(FeatureCases()), Name);
INSTANTIATE_TEST_SUITE_P(Points, BatchValidationTest, ::testing::ValuesIn(PointCases()), Name);
INSTANTIATE_TEST_SUITE_P(Graph, BatchValidationTest, ::testing::ValuesIn(GraphCases()), Name);

}  // namespace
}  // namespace corbslam::map_store
