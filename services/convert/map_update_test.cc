#include "services/convert/map_update.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "services/convert/limits.h"
#include "services/convert/testing/test_data.h"
#include "slam/coding/testing/plausible_features.h"

namespace corbslam::services {
namespace {

using test_data::kMap;
using test_data::kOtherMap;
using test_data::MakeBatch;
using ::testing::AllOf;
using ::testing::HasSubstr;

void ExpectSame(const Rigid3d& a, const Rigid3d& b, double tolerance) {
  EXPECT_LT((a.rotation.coeffs() - b.rotation.coeffs()).norm(), tolerance);
  EXPECT_LT((a.translation - b.translation).norm(), tolerance);
}

void ExpectSameKeyframes(const MapUpdateBatch& a, const MapUpdateBatch& b) {
  ASSERT_EQ(a.full_keyframes.size(), b.full_keyframes.size());
  for (size_t i = 0; i < a.full_keyframes.size(); ++i) {
    const FullKeyframe& x = a.full_keyframes[i];
    const FullKeyframe& y = b.full_keyframes[i];
    EXPECT_EQ(x.payload->id, y.payload->id);
    EXPECT_EQ(x.payload->timestamp_ns, y.payload->timestamp_ns);
    EXPECT_EQ(x.payload->features.keypoints, y.payload->features.keypoints);
    EXPECT_EQ(x.payload->features.descriptors, y.payload->features.descriptors);
    EXPECT_EQ(*x.payload->camera, *y.payload->camera);
    EXPECT_EQ(x.parent, y.parent);
    ExpectSame(x.camera_from_local, y.camera_from_local, 1e-15);
  }
}

void ExpectSamePoints(const MapUpdateBatch& a, const MapUpdateBatch& b) {
  ASSERT_EQ(a.full_points.size(), b.full_points.size());
  for (size_t i = 0; i < a.full_points.size(); ++i) {
    const FullMapPoint& x = a.full_points[i];
    const FullMapPoint& y = b.full_points[i];
    EXPECT_EQ(x.id, y.id);
    EXPECT_EQ(x.reference, y.reference);
    EXPECT_EQ(x.descriptor, y.descriptor);
    EXPECT_EQ(x.position_in_local, y.position_in_local);
    EXPECT_LT((x.normal_in_local - y.normal_in_local).norm(), 2e-4);
    EXPECT_EQ(x.min_distance, y.min_distance);
    EXPECT_EQ(x.max_distance, y.max_distance);
  }
  ASSERT_EQ(a.light_points.size(), b.light_points.size());
  EXPECT_EQ(a.light_points[0].id, b.light_points[0].id);
  EXPECT_EQ(a.light_points[0].position_in_local, b.light_points[0].position_in_local);
}

void ExpectSameGraph(const MapUpdateBatch& a, const MapUpdateBatch& b) {
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (size_t i = 0; i < a.observations.size(); ++i) {
    EXPECT_EQ(a.observations[i].kind, b.observations[i].kind) << i;
    EXPECT_EQ(a.observations[i].point, b.observations[i].point) << i;
    EXPECT_EQ(a.observations[i].keyframe, b.observations[i].keyframe) << i;
    EXPECT_EQ(a.observations[i].keypoint, b.observations[i].keypoint) << i;
  }
  ASSERT_EQ(a.replacements.size(), b.replacements.size());
  for (size_t i = 0; i < a.replacements.size(); ++i) {
    EXPECT_EQ(a.replacements[i].replaced, b.replacements[i].replaced);
    EXPECT_EQ(a.replacements[i].survivor, b.replacements[i].survivor);
  }
  EXPECT_EQ(a.removed_points, b.removed_points);
  ASSERT_EQ(a.removed_keyframes.size(), b.removed_keyframes.size());
  for (size_t i = 0; i < a.removed_keyframes.size(); ++i) {
    EXPECT_EQ(a.removed_keyframes[i].id, b.removed_keyframes[i].id);
    EXPECT_EQ(a.removed_keyframes[i].parent, b.removed_keyframes[i].parent);
    ExpectSame(a.removed_keyframes[i].parent_from_removed,
               b.removed_keyframes[i].parent_from_removed, 1e-15);
  }
  ASSERT_EQ(a.loop_edges.size(), b.loop_edges.size());
  for (size_t i = 0; i < a.loop_edges.size(); ++i) {
    EXPECT_EQ(a.loop_edges[i].a, b.loop_edges[i].a);
    EXPECT_EQ(a.loop_edges[i].b, b.loop_edges[i].b);
    EXPECT_EQ(a.loop_edges[i].b_from_a.scale, b.loop_edges[i].b_from_a.scale);
  }
}

void ExpectSameFrames(const MapUpdateBatch& a, const MapUpdateBatch& b) {
  ASSERT_EQ(a.tracked_frames.size(), b.tracked_frames.size());
  for (size_t i = 0; i < a.tracked_frames.size(); ++i) {
    EXPECT_EQ(a.tracked_frames[i].timestamp_ns, b.tracked_frames[i].timestamp_ns);
    EXPECT_EQ(a.tracked_frames[i].reference, b.tracked_frames[i].reference);
    ExpectSame(a.tracked_frames[i].reference_from_camera, b.tracked_frames[i].reference_from_camera,
               1e-6);
  }
  EXPECT_EQ(a.lost_frames_ns, b.lost_frames_ns);
  EXPECT_EQ(a.points_follow, b.points_follow);
  EXPECT_EQ(a.closes_local_map, b.closes_local_map);
}

void ExpectSameBatch(const MapUpdateBatch& a, const MapUpdateBatch& b) {
  EXPECT_EQ(a.local_map, b.local_map);
  EXPECT_EQ(a.number, b.number);
  EXPECT_EQ(a.first_camera_index, b.first_camera_index);
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) EXPECT_EQ(*a.cameras[i], *b.cameras[i]);
  EXPECT_EQ(a.recorded_cameras, b.recorded_cameras);
  ExpectSameKeyframes(a, b);
  ExpectSamePoints(a, b);
  ExpectSameGraph(a, b);
  ExpectSameFrames(a, b);
}

MapUpdateBatch MakeFullBatch(std::mt19937& random) {
  MapUpdateBatch batch = MakeBatch(random, kMap, 1);
  batch.recorded_cameras = {{{700, 701, 600, 180, RadialTangential{-0.3, 0.1, 0.001, -0.002, 0.01}},
                             {test_data::MakeMotion(random).rotation, Eigen::Vector3d::Zero()},
                             test_data::MakeMotion(random)}};
  batch.replacements = {{{kMap, 1}, {kOtherMap, 17}}, {{kMap, 2}, {kMap, 3}}};
  batch.observations.push_back({ObservationChange::Kind::kAdded, {kOtherMap, 4000}, {kMap, 10}, 7});
  batch.removed_points = {{kMap, 9}, {kMap, 4}};
  batch.removed_keyframes = {{{kMap, 11}, {kMap, 10}, test_data::MakeMotion(random)},
                             {{kMap, 12}, KeyframeId(), Rigid3d::Identity()}};
  batch.loop_edges = {{{kMap, 10}, {kOtherMap, 3}, test_data::MakeSimilarity(random)}};
  batch.points_follow = true;
  batch.closes_local_map = true;
  return batch;
}

// Returns the batch that the parts, sent over the wire, come to.
MapUpdateBatch SendParts(const std::vector<v1::MapUpdateBatch>& parts) {
  BatchAssembler assembler;
  CameraBook cameras;
  for (size_t i = 0; i < parts.size(); ++i) {
    v1::MapUpdateBatch received;
    EXPECT_TRUE(received.ParseFromString(parts[i].SerializeAsString()));
    auto batch = assembler.Add(received, cameras);
    EXPECT_TRUE(batch.ok()) << batch.status();
    EXPECT_EQ(batch->has_value(), i + 1 == parts.size());
    if (batch->has_value()) return **batch;
  }
  return {};
}

TEST(MapUpdateTest, PassesTheWireUnchanged) {
  std::mt19937 random(1);
  const MapUpdateBatch batch = MakeFullBatch(random);
  CameraBook sent;
  const auto parts = ToProto(batch, sent, kPartBytes);
  ASSERT_EQ(parts.size(), 1u);
  ExpectSameBatch(batch, SendParts(parts));
}

TEST(MapUpdateTest, IsSplitWhereItIsTooLong) {
  std::mt19937 random(2);
  const MapUpdateBatch batch = MakeFullBatch(random);
  CameraBook sent;
  const auto parts = ToProto(batch, sent, 1500);
  ASSERT_GT(parts.size(), 3u);
  // Keyframes of 30 features have about 1,300 bytes and are not split.
  for (const auto& part : parts) EXPECT_LT(part.ByteSizeLong(), 3500u);
  ExpectSameBatch(batch, SendParts(parts));
}

TEST(MapUpdateTest, LaterBatchesNameTheCamerasThatAnotherStreamSent) {
  std::mt19937 random(3);
  const MapUpdateBatch second = MakeBatch(random, kMap, 2);
  ASSERT_TRUE(second.cameras.empty());
  CameraBook nothing_sent;
  const MapUpdateBatch received = SendParts(ToProto(second, nothing_sent, kPartBytes));
  EXPECT_TRUE(received.cameras.empty());
  EXPECT_EQ(*received.full_keyframes[0].payload->camera, *test_data::MakeCamera());
}

TEST(MapUpdateTest, AKeyframeOfTwoThousandFeaturesTakesLessThan90Kilobytes) {
  std::mt19937 random(4);
  const MapUpdateBatch batch = MakeBatch(random, kMap, 1, 1, 2000);
  CameraBook sent;
  const auto parts = ToProto(batch, sent, kPartBytes);
  EXPECT_LT(parts[0].full_keyframes(0).ByteSizeLong(), 90'000u);
}

// Returns a batch with keyframes such as a camera's, and points that look as one of them or as
// nothing that is there.
MapUpdateBatch MakeCodableBatch() {
  std::mt19937 random(6);
  MapUpdateBatch batch = MakeFullBatch(random);
  for (FullKeyframe& keyframe : batch.full_keyframes) {
    const uint32_t index = keyframe.payload->id.index;
    keyframe.payload =
        WithFeatures(*keyframe.payload, testing::MakePlausibleFeatures(index, 400, {1241, 376}));
  }
  const KeyframePayload& first = *batch.full_keyframes[0].payload;
  for (size_t i = 0; i < batch.full_points.size(); ++i) {
    if (i % 4 == 0) continue;
    batch.full_points[i].reference = first.id;
    batch.full_points[i].descriptor = first.features.descriptors[7 * i];
  }
  return batch;
}

TEST(CodedMapUpdateTest, SaysTheSameInHalfTheBytes) {
  const MapUpdateBatch batch = MakeCodableBatch();
  CameraBook sent;
  CameraBook sent_coded;
  const auto plain = ToProto(batch, sent, kPartBytes);
  const auto coded = ToProto(batch, sent_coded, kPartBytes, FeatureForm::kCoded);
  ASSERT_EQ(coded.size(), 1u);
  const v1::FullKeyframe& keyframe = coded[0].full_keyframes(0);
  EXPECT_EQ(keyframe.payload().features().x_px64_size(), 0);
  EXPECT_TRUE(keyframe.payload().features().descriptors().empty());
  EXPECT_LT(keyframe.ByteSizeLong(), plain[0].full_keyframes(0).ByteSizeLong() * 6 / 10);
  EXPECT_TRUE(coded[0].full_points().descriptors().empty());
  EXPECT_LT(coded[0].full_points().coded_descriptors().size(),
            plain[0].full_points().descriptors().size());
  ExpectSameBatch(SendParts(plain), SendParts(coded));
  ExpectSameBatch(batch, SendParts(coded));
}

TEST(CodedMapUpdateTest, EachPartIsReadByItself) {
  const MapUpdateBatch batch = MakeCodableBatch();
  for (const size_t part_bytes : {size_t{1500}, size_t{9000}, size_t{12'000}, size_t{30'000}}) {
    CameraBook sent;
    ExpectSameBatch(batch, SendParts(ToProto(batch, sent, part_bytes, FeatureForm::kCoded)));
  }
}

TEST(CodedMapUpdateTest, LimitsCountWhatItTakesUncoded) {
  const MapUpdateBatch batch = MakeCodableBatch();
  CameraBook sent;
  CameraBook sent_coded;
  const auto plain = ToProto(batch, sent, kPartBytes);
  const auto coded = ToProto(batch, sent_coded, kPartBytes, FeatureForm::kCoded);
  EXPECT_EQ(UncodedBytes(plain[0]), plain[0].ByteSizeLong());
  EXPECT_GE(UncodedBytes(coded[0]), plain[0].ByteSizeLong());
}

TEST(CodedMapUpdateTest, WhatCameCodedGoesOnAsItCame) {
  CameraBook sent;
  const auto parts = ToProto(MakeCodableBatch(), sent, kPartBytes, FeatureForm::kCoded);
  const std::string& came = parts[0].full_keyframes(0).payload().features().coded();
  MapUpdateBatch batch = SendParts(parts);
  FullKeyframe& keyframe = batch.full_keyframes[0];
  ASSERT_NE(keyframe.code, nullptr);
  EXPECT_EQ(*keyframe.code, came);

  // Another string in the code's place shows that the code itself is sent, and only to readers of
  // coded features.
  const auto marked = std::make_shared<const std::string>("as it came");
  KeyframePayload payload = *keyframe.payload;
  payload.code = marked;
  const auto other = MakeKeyframePayload(std::move(payload));
  v1::KeyframePayload coded;
  ToProto(*other, &coded, FeatureForm::kCoded);
  EXPECT_EQ(coded.features().coded(), "as it came");
  v1::KeyframePayload plain;
  ToProto(*other, &plain);
  EXPECT_TRUE(plain.features().coded().empty());
  EXPECT_EQ(plain.features().x_px64_size(), static_cast<int>(other->features.keypoints.size()));

  // A code that nobody keeps is made anew.
  keyframe.code.reset();
  EXPECT_TRUE(keyframe.payload->code.expired());
  v1::KeyframePayload anew;
  ToProto(*keyframe.payload, &anew, FeatureForm::kCoded);
  EXPECT_EQ(anew.features().coded(), came);
}

// Makes a coded batch bad, as Malformed does one with columns.
struct MalformedCode {
  const char* name;
  std::function<void(v1::MapUpdateBatch&)> harm;
  const char* says;
};

class MalformedCodeTest : public ::testing::TestWithParam<MalformedCode> {};

TEST_P(MalformedCodeTest, IsRefusedWithTheKeyframeOrField) {
  CameraBook sent;
  v1::MapUpdateBatch proto = ToProto(MakeCodableBatch(), sent, kPartBytes, FeatureForm::kCoded)[0];
  GetParam().harm(proto);
  CameraBook cameras;
  const absl::Status status = FromProto(proto, cameras).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
}

// Makes a good batch bad by `harm`.
struct Malformed {
  const char* name;
  std::function<void(v1::MapUpdateBatch&)> harm;
  absl::StatusCode code;
  const char* says;
};

class MalformedBatchTest : public ::testing::TestWithParam<Malformed> {};

TEST_P(MalformedBatchTest, IsRefusedWithTheItemAndTheLimit) {
  std::mt19937 random(5);
  CameraBook sent;
  v1::MapUpdateBatch proto = ToProto(MakeFullBatch(random), sent, kPartBytes)[0];
  GetParam().harm(proto);
  CameraBook cameras;
  const absl::Status status = FromProto(proto, cameras).status();
  EXPECT_EQ(status.code(), GetParam().code) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr auto kDenied = absl::StatusCode::kPermissionDenied;
using Batch = v1::MapUpdateBatch;

v1::Features& FeaturesOf(Batch& b) {
  return *b.mutable_full_keyframes(0)->mutable_payload()->mutable_features();
}
v1::Rigid& PoseOf(Batch& b) { return *b.mutable_full_keyframes(0)->mutable_camera_from_local(); }

std::string& CodeOf(Batch& b) { return *FeaturesOf(b).mutable_coded(); }

INSTANTIATE_TEST_SUITE_P(
    Kinds, MalformedCodeTest,
    ::testing::Values(
        MalformedCode{"Version", [](Batch& b) { CodeOf(b)[0] = 3; }, "full keyframe "},
        MalformedCode{"VersionItself", [](Batch& b) { CodeOf(b)[0] = 3; },
                      "coded features: version is 3, this program reads 1"},
        MalformedCode{"CutShort", [](Batch& b) { CodeOf(b).resize(3000); },
                      "cut short, or a stream is longer"},
        MalformedCode{"More", [](Batch& b) { CodeOf(b) += "x"; }, "or more follows it"},
        MalformedCode{"BesideColumns", [](Batch& b) { FeaturesOf(b).add_x_px64(1); },
                      "x_px64 has 1 entries beside coded, must have none"},
        MalformedCode{"BesideDescriptors",
                      [](Batch& b) { FeaturesOf(b).set_descriptors(std::string(32, 'x')); },
                      "descriptors has 32 entries beside coded, must have none"},
        MalformedCode{"OutsideOfTheCamera",
                      [](Batch& b) { b.mutable_cameras(0)->set_width_px(300); }, "in pixels is"},
        MalformedCode{
            "PointsVersion",
            [](Batch& b) { (*b.mutable_full_points()->mutable_coded_descriptors())[0] = 7; },
            "full_points: coded descriptors: version is 7, this program reads 1"},
        MalformedCode{"PointsOfAKeyframeThatIsNotThere",
                      [](Batch& b) { b.mutable_full_keyframes()->DeleteSubrange(0, 1); },
                      "full_points: coded descriptors: "},
        MalformedCode{"PointsTwice",
                      [](Batch& b) { b.mutable_full_points()->set_descriptors("x"); },
                      "descriptors has 1 entries, must have 0"}),
    [](const auto& info) { return std::string(info.param.name); });

INSTANTIATE_TEST_SUITE_P(
    All, MalformedBatchTest,
    ::testing::Values(
        Malformed{"NoLocalMap", [](Batch& b) { b.set_local_map(0); }, kInvalid, "local_map is 0"},
        Malformed{"NoNumber", [](Batch& b) { b.set_number(0); }, kInvalid, "number is 0"},
        Malformed{"TableOfZero", [](Batch& b) { b.set_other_local_maps(0, 0); }, kInvalid,
                  "table is 0"},
        Malformed{"BadCamera", [](Batch& b) { b.mutable_cameras(0)->set_fx_px(kNan); }, kInvalid,
                  "camera.fx_px is nan"},
        Malformed{"NegativeBaseline",
                  [](Batch& b) { b.mutable_cameras(0)->set_baseline_m(-1); }, kInvalid,
                  "camera.baseline_m is -1"},
        Malformed{"BadRecordedCamera",
                  [](Batch& b) { b.mutable_recorded_cameras(0)->set_fy_px(0); }, kInvalid,
                  "recorded camera: fy_px is 0"},
        Malformed{"HalfADistortion",
                  [](Batch& b) {
                    b.mutable_recorded_cameras(0)->mutable_distortion()->RemoveLast();
                  },
                  kInvalid, "distortion"},
        Malformed{"UnknownLens",
                  [](Batch& b) {
                    b.mutable_recorded_cameras(0)->set_lens_model(static_cast<v1::LensModel>(9));
                  },
                  kInvalid, "lens_model is 9"},
        Malformed{"NumbersOfAnotherLens",
                  [](Batch& b) {
                    b.mutable_recorded_cameras(0)->set_lens_model(v1::LENS_MODEL_EQUIDISTANT);
                  },
                  kInvalid, "distortion"},
        Malformed{"RectificationThatMoves",
                  [](Batch& b) {
                    b.mutable_recorded_cameras(0)->mutable_camera_from_recorded()->set_translation(
                        0, 1);
                  },
                  kInvalid, "camera_from_recorded"},
        Malformed{"UnknownCamera",
                  [](Batch& b) {
                    b.mutable_full_keyframes(0)->mutable_payload()->set_camera_index(3);
                  },
                  kInvalid, "camera_index is 3"},
        Malformed{"NegativeTime",
                  [](Batch& b) {
                    b.mutable_full_keyframes(0)->mutable_payload()->set_timestamp_ns(-5);
                  },
                  kInvalid, "timestamp_ns is -5"},
        Malformed{"NanRotation", [](Batch& b) { PoseOf(b).set_rotation_wxyz(2, kNan); }, kInvalid,
                  "length of the quaternion is nan"},
        Malformed{"LongRotation", [](Batch& b) { PoseOf(b).set_rotation_wxyz(0, 2); }, kInvalid,
                  "length of the quaternion"},
        Malformed{"ShortTranslation",
                  [](Batch& b) { PoseOf(b).mutable_translation()->Truncate(2); }, kInvalid,
                  "translation has 2 entries, must have 3"},
        Malformed{"InfiniteTranslation",
                  [](Batch& b) {
                    PoseOf(b).set_translation(1, std::numeric_limits<double>::infinity());
                  },
                  kInvalid, "coordinate 1 is inf"},
        Malformed{"FewerY", [](Batch& b) { FeaturesOf(b).mutable_y_px64()->RemoveLast(); },
                  kInvalid, "y_px64 has 29 entries, must have 30"},
        Malformed{"FewerDescriptors",
                  [](Batch& b) { FeaturesOf(b).mutable_descriptors()->pop_back(); }, kInvalid,
                  "descriptors has 959 entries, must have 960"},
        Malformed{"NoDescriptors", [](Batch& b) { FeaturesOf(b).clear_descriptors(); }, kInvalid,
                  "descriptors has 0 entries"},
        Malformed{"HighOctave", [](Batch& b) { FeaturesOf(b).mutable_octaves()->at(4) = 8; },
                  kInvalid, "octaves[4] is 8, must be in [0, 7]"},
        Malformed{"FarKeypoint", [](Batch& b) { FeaturesOf(b).set_x_px64(1, 1 << 30); }, kInvalid,
                  "x_px64[1]"},
        Malformed{"WideAngle", [](Batch& b) { FeaturesOf(b).set_angle_turn14(0, 16384); }, kInvalid,
                  "angle_turn14[0] is 16384"},
        Malformed{"ManyKeypoints",
                  [](Batch& b) { FeaturesOf(b).mutable_x_px64()->Resize(20001, 0); }, kInvalid,
                  "number of keypoints is 20001, must be in [0, 20000]"},
        Malformed{"LastIndex",
                  [](Batch& b) { b.mutable_full_keyframes(0)->set_index(0xffffffffu); }, kInvalid,
                  "index is 4294967295"},
        Malformed{"ParentOfUnknownSlot",
                  [](Batch& b) { b.mutable_full_keyframes(1)->mutable_parent()->set_slot(9); },
                  kInvalid, "slot is 9, must be in [0, 2]"},
        Malformed{"NanPoint",
                  [](Batch& b) {
                    b.mutable_full_points()->set_positions(4, static_cast<float>(kNan));
                  },
                  kInvalid, "map point c0ffee00c0ffee01:101: coordinate 1 is nan"},
        Malformed{"LongNormal",
                  [](Batch& b) { b.mutable_full_points()->set_normals_8191(0, 20000); }, kInvalid,
                  "length of the normal"},
        Malformed{"TurnedDistances",
                  [](Batch& b) { b.mutable_full_points()->set_min_distances(0, 1e6f); }, kInvalid,
                  "in order"},
        Malformed{"IndexBelowZero",
                  [](Batch& b) {
                    b.mutable_full_points()->mutable_ids()->set_index_deltas(0, -1);
                  },
                  kInvalid, "ids: index of entry 0 is -1"},
        Malformed{"IndexOverflow",
                  [](Batch& b) {
                    b.mutable_full_points()->mutable_ids()->set_index_deltas(
                        1, std::numeric_limits<int64_t>::max());
                  },
                  kInvalid, "ids: index of entry 1"},
        Malformed{"SomebodyElsesPoint",
                  [](Batch& b) { b.mutable_removed_points()->add_slots(2);
                    b.mutable_removed_points()->add_slots(1); },
                  kDenied, "0000000000000002:9"},
        Malformed{"SomebodyElsesKeyframe",
                  [](Batch& b) {
                    auto* slots = b.mutable_observations()->mutable_keyframes()->mutable_slots();
                    slots->Resize(b.observations().keypoints_size(), 2);
                  },
                  kDenied, "observations names 0000000000000002:10"},
        Malformed{"ObservationWithoutPoint",
                  [](Batch& b) {
                    b.mutable_observations()->mutable_points()->mutable_slots()->Set(0, 0);
                  },
                  kInvalid, "points.slots[0] is 0, must be in [1, 2]"},
        Malformed{"UnknownKind",
                  [](Batch& b) {
                    b.mutable_observations()->set_kinds(
                        2, v1::ObservationChanges::KIND_UNSPECIFIED);
                  },
                  kInvalid, "kinds[2] is 0, must be in [1, 2]"},
        Malformed{"HighKeypoint",
                  [](Batch& b) { b.mutable_observations()->set_keypoints(3, 20000); }, kInvalid,
                  "keypoints[3] of keyframe c0ffee00c0ffee01:10 is 20000"},
        Malformed{"ReplacesItself",
                  [](Batch& b) {
                    *b.mutable_replacements()->mutable_survivors() = b.replacements().replaced();
                  },
                  kInvalid, "replaces itself"},
        Malformed{"LoopToNothing",
                  [](Batch& b) { b.mutable_loop_edges(0)->mutable_b()->set_slot(0); }, kInvalid,
                  "loop_edges[0]: must name two keyframes"},
        Malformed{"TinyScale",
                  [](Batch& b) { b.mutable_loop_edges(0)->mutable_b_from_a()->set_scale(0); },
                  kInvalid, "scale is 0"},
        Malformed{"FramesOverflow",
                  [](Batch& b) {
                    b.mutable_tracked_frames()->set_timestamp_deltas_ns(
                        1, std::numeric_limits<int64_t>::max());
                  },
                  kInvalid, "timestamp_deltas_ns[1]"},
        Malformed{"FramesOverflowTogether",
                  [](Batch& b) {
                    for (int i : {0, 1}) {
                      b.mutable_tracked_frames()->set_timestamp_deltas_ns(i, int64_t{1} << 62);
                    }
                  },
                  kInvalid, "timestamp_deltas_ns[1]"},
        Malformed{"ShortFrameMotion",
                  [](Batch& b) {
                    b.mutable_tracked_frames()->mutable_reference_from_camera()->RemoveLast();
                  },
                  kInvalid, "reference_from_camera has 13 entries, must have 14"}),
    [](const auto& param) { return std::string(param.param.name); });

TEST(BatchAssemblerTest, RefusesAnotherBatchInBetween) {
  std::mt19937 random(6);
  CameraBook sent;
  v1::MapUpdateBatch first = ToProto(MakeFullBatch(random), sent, kPartBytes)[0];
  first.set_continues(true);
  v1::MapUpdateBatch second = first;
  second.set_number(2);
  BatchAssembler assembler;
  CameraBook cameras;
  ASSERT_TRUE(assembler.Add(first, cameras).ok());
  const absl::Status status = assembler.Add(second, cameras).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("is unfinished"));
}

TEST(BatchAssemblerTest, HoldsOnlySoMuch) {
  std::mt19937 random(7);
  CameraBook sent;
  v1::MapUpdateBatch part = ToProto(MakeBatch(random, kMap, 1, 20, 1000), sent, kMaxUpdateBytes)[0];
  part.set_continues(true);
  BatchAssembler assembler;
  CameraBook cameras;
  absl::Status status;
  for (size_t bytes = 0; status.ok() && bytes <= 2 * kMaxUpdateBytes;
       bytes += part.ByteSizeLong()) {
    status = assembler.Add(part, cameras).status();
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
}

// An item takes a byte on the wire and sixteen in memory.
TEST(BatchAssemblerTest, CountsItemsBeforeItConvertsThem) {
  v1::MapUpdateBatch part;
  part.set_local_map(kMap.value);
  part.set_number(1);
  part.mutable_removed_points()->mutable_index_deltas()->Resize(3'000'000, 0);
  EXPECT_LT(part.ByteSizeLong(), 4u << 20);
  BatchAssembler assembler;
  CameraBook cameras;
  const absl::Status status = assembler.Add(part, cameras).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("3000000 items; the limits are"));
}

TEST(CameraBookTest, HoldsOnlySoMany) {
  CameraBook book;
  const auto camera = test_data::MakeCamera();
  absl::Status status;
  uint64_t local_map = 1;
  for (; status.ok() && local_map < 2 * kMaxCamerasOfStream; ++local_map) {
    status = book.Add({local_map}, 0, camera);
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(local_map, kMaxCamerasOfStream + 2);
  EXPECT_TRUE(book.Add({1}, 0, camera).ok()) << "known ones are no more";
}

}  // namespace
}  // namespace corbslam::services
