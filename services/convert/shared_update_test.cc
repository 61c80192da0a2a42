#include "services/convert/shared_update.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "absl/strings/str_cat.h"
#include "services/convert/limits.h"
#include "services/convert/testing/test_data.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

template <typename Pose>
void ExpectSamePoses(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].camera_from_global.scale, b[i].camera_from_global.scale);
    EXPECT_EQ(a[i].camera_from_global.translation, b[i].camera_from_global.translation);
  }
}

void ExpectSame(const SharedUpdate& a, const SharedUpdate& b) {
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.restart, b.restart);
  EXPECT_EQ(a.more_places, b.more_places);
  EXPECT_EQ(a.apart, b.apart);
  EXPECT_EQ(a.in_metres, b.in_metres);
  EXPECT_EQ(a.local_map, b.local_map);
  ASSERT_EQ(a.global_from_local.has_value(), b.global_from_local.has_value());
  if (a.global_from_local.has_value()) {
    EXPECT_EQ(a.global_from_local->scale, b.global_from_local->scale);
    EXPECT_EQ(a.global_from_local->translation, b.global_from_local->translation);
  }
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (size_t i = 0; i < a.keyframes.size(); ++i) {
    EXPECT_EQ(a.keyframes[i].payload->id, b.keyframes[i].payload->id);
    EXPECT_EQ(a.keyframes[i].payload->features.descriptors,
              b.keyframes[i].payload->features.descriptors);
    EXPECT_EQ(a.keyframes[i].parent, b.keyframes[i].parent);
    EXPECT_EQ(a.keyframes[i].points, b.keyframes[i].points);
    EXPECT_EQ(a.keyframes[i].camera_from_global.scale, b.keyframes[i].camera_from_global.scale);
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.points[0].id, b.points[0].id);
  EXPECT_EQ(a.points[0].position_in_global, b.points[0].position_in_global);
  ExpectSamePoses(a.moved_keyframes, b.moved_keyframes);
  ExpectSamePoses(a.own_keyframes, b.own_keyframes);
  EXPECT_EQ(a.own_keyframes[0].camera_from_local.translation,
            b.own_keyframes[0].camera_from_local.translation);
  EXPECT_EQ(a.own_keyframes[0].camera_from_local.rotation.coeffs(),
            b.own_keyframes[0].camera_from_local.rotation.coeffs());
  ASSERT_EQ(a.moved_points.size(), b.moved_points.size());
  EXPECT_EQ(a.moved_points[0].position_in_global, b.moved_points[0].position_in_global);
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (size_t i = 0; i < a.observations.size(); ++i) {
    EXPECT_EQ(a.observations[i].kind, b.observations[i].kind);
    EXPECT_EQ(a.observations[i].point, b.observations[i].point);
    EXPECT_EQ(a.observations[i].keyframe, b.observations[i].keyframe);
  }
  ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
  EXPECT_EQ(a.landmarks[0].survivor, b.landmarks[0].survivor);
  EXPECT_EQ(a.landmarks[0].members, b.landmarks[0].members);
  EXPECT_EQ(a.removed_keyframes, b.removed_keyframes);
  EXPECT_EQ(a.removed_points, b.removed_points);
}

TEST(SharedUpdateTest, PassesTheWireUnchangedInOneOrManyParts) {
  std::mt19937 random(1);
  const SharedUpdate update = test_data::MakeSharedUpdate(random);
  for (const size_t part_bytes : {kPartBytes, size_t{400}}) {
    CameraBook sent;
    CameraBook received;
    SharedUpdateAssembler assembler;
    const auto parts = ToProto(update, sent, part_bytes);
    EXPECT_EQ(parts.size() > 1, part_bytes != kPartBytes);
    for (size_t i = 0; i < parts.size(); ++i) {
      const auto whole = assembler.Add(parts[i], received);
      ASSERT_TRUE(whole.ok()) << whole.status();
      ASSERT_EQ(whole->has_value(), i + 1 == parts.size());
      if (whole->has_value()) ExpectSame(update, **whole);
    }
  }
}

TEST(SharedUpdateTest, ACameraIsNamedOnceAStream) {
  std::mt19937 random(2);
  const SharedUpdate update = test_data::MakeSharedUpdate(random);
  CameraBook sent;
  EXPECT_EQ(ToProto(update, sent, kPartBytes)[0].cameras_size(), 1);
  EXPECT_EQ(ToProto(update, sent, kPartBytes)[0].cameras_size(), 0);
}

TEST(SharedUpdateTest, SightingsBeyondTheKeypointsAreRefused) {
  std::mt19937 random(3);
  CameraBook sent;
  v1::SharedUpdate proto = ToProto(test_data::MakeSharedUpdate(random), sent, kPartBytes)[0];
  proto.mutable_keyframes(1)->set_keypoint_deltas(1, 4000000000u);
  CameraBook received;
  const absl::Status status = FromProto(proto, received).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("keyframes[1]"));
}

TEST(SharedUpdateTest, AnOwnPlaceWithoutItsLocalPoseIsRefusedByName) {
  std::mt19937 random(4);
  CameraBook sent;
  v1::SharedUpdate proto = ToProto(test_data::MakeSharedUpdate(random), sent, kPartBytes)[0];
  proto.mutable_own_keyframes(0)->clear_camera_from_local();
  CameraBook received;
  const absl::Status status = FromProto(proto, received).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("camera_from_local"));
  EXPECT_THAT(std::string(status.message()), HasSubstr(ToString(KeyframeId{test_data::kMap, 2})));
}

TEST(SessionTest, RequestAndGrantPassTheWire) {
  SessionRequest request{"m",    "alpha",           5, {test_data::kMap, test_data::kOtherMap},
                         0xfeed, /*take_over=*/true};
  request.capabilities.coded_features = true;
  request.downlink_bytes_per_second = 32000;
  request.mission_uid = "0123456789abcdef";
  v1::OpenSession proto;
  ToProto(request, &proto);
  EXPECT_EQ(proto.mission(), "missions/m");
  const auto read = FromProto(proto);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->mission, "m");
  EXPECT_EQ(read->agent, "alpha");
  EXPECT_EQ(read->last_revision, 5u);
  EXPECT_EQ(read->local_maps, request.local_maps);
  EXPECT_EQ(read->instance, request.instance);
  EXPECT_TRUE(read->take_over);
  EXPECT_TRUE(read->capabilities.coded_features);
  EXPECT_FALSE(read->capabilities.points_follow);
  EXPECT_EQ(read->downlink_bytes_per_second, 32000u);
  EXPECT_EQ(read->mission_uid, "0123456789abcdef");
  proto.set_agent("a/b");
  EXPECT_FALSE(FromProto(proto).ok());
}

TEST(SessionTest, WhatIsUnderstoodPassesTheWire) {
  SessionGrant grant;
  grant.capabilities.points_follow = true;
  grant.mission_uid = "fedc";
  v1::SessionGrant proto;
  ToProto(grant, &proto);
  // A newer store sends a capability that is not known here.
  proto.add_capabilities(static_cast<v1::Capability>(77));
  const auto read = FromProto(proto);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_TRUE(read->capabilities.points_follow);
  EXPECT_FALSE(read->capabilities.coded_features);
  EXPECT_EQ(read->mission_uid, "fedc");
  // An older store sends no capabilities.
  EXPECT_FALSE(FromProto(v1::SessionGrant())->capabilities.points_follow);
}

TEST(SessionTest, ADownlinkThatNothingPassesIsRefused) {
  SessionRequest request;
  request.mission = "m";
  request.agent = "alpha";
  v1::OpenSession proto;
  ToProto(request, &proto);
  ASSERT_TRUE(FromProto(proto).ok());
  for (const uint64_t bound : {uint64_t{1}, uint64_t{999}, (uint64_t{1} << 40) + 1}) {
    proto.set_downlink_bytes_per_second(bound);
    const absl::Status status = FromProto(proto).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr("downlink_bytes_per_second"));
  }
}

TEST(SessionTest, WhatIsWantedPassesTheWire) {
  SessionRequest request;
  request.mission = "m";
  request.agent = "alpha";
  for (const ShareScope& scope : {ShareScope{ShareMode::kNone}, ShareScope{ShareMode::kCorrections},
                                  ShareScope{ShareMode::kNearby}, ShareScope{ShareMode::kNearby, 7},
                                  ShareScope{ShareMode::kNearby, 1e6}, ShareScope{}}) {
    request.share = scope;
    v1::OpenSession proto;
    ToProto(request, &proto);
    const auto read = FromProto(proto);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->share, scope);
  }
}

TEST(SessionTest, WhoSaysNothingOfItWantsEverything) {
  v1::OpenSession proto;
  proto.set_mission("missions/m");
  proto.set_agent("alpha");
  EXPECT_EQ(FromProto(proto)->share.mode, ShareMode::kEverything);
  proto.set_share(v1::SHARE_EVERYTHING);
  EXPECT_EQ(FromProto(proto)->share.mode, ShareMode::kEverything);
  proto.set_share(v1::SHARE_NEARBY);
  EXPECT_EQ(FromProto(proto)->share, (ShareScope{ShareMode::kNearby, 50}));
  // A radius says nothing in other modes.
  proto.set_share(v1::SHARE_CORRECTIONS);
  proto.set_share_radius_m(7);
  EXPECT_EQ(FromProto(proto)->share, ShareScope{ShareMode::kCorrections});
}

TEST(SessionTest, AWishThatIsNotKnownIsRefusedByNameValueAndLimits) {
  v1::OpenSession proto;
  proto.set_mission("missions/m");
  proto.set_agent("alpha");
  for (const int share : {-1, 5, 77}) {
    proto.set_share(static_cast<v1::Share>(share));
    const absl::Status status = FromProto(proto).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()),
                HasSubstr(absl::StrCat("share is ", share, ", must be in [0, 4]")));
  }
}

TEST(SessionTest, ARadiusOutOfItsLimitsIsRefusedByNameValueAndLimitsInEveryMode) {
  v1::OpenSession proto;
  proto.set_mission("missions/m");
  proto.set_agent("alpha");
  for (const v1::Share share : {v1::SHARE_NEARBY, v1::SHARE_NONE}) {
    proto.set_share(share);
    for (const double radius_m : {0.5, -3.0, 2e6, std::nan(""), HUGE_VAL}) {
      proto.set_share_radius_m(radius_m);
      const absl::Status status = FromProto(proto).status();
      EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << radius_m;
      EXPECT_THAT(
          std::string(status.message()),
          HasSubstr(absl::StrCat("share_radius_m is ", radius_m, ", must be in [1, 1e+06]")));
    }
  }
}

}  // namespace
}  // namespace corbslam::services
