// Tests what an agent says that changes nothing, on the wire.
#include "services/convert/localised_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "services/convert/limits.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

LocalisedFrames MakeLocalised() {
  LocalisedFrames localised;
  localised.frames = {{5, Rigid3d{Eigen::Quaterniond::Identity(), {1, 2, 3}}}, {6, std::nullopt}};
  localised.run = 0xfedcba9876543210u;
  localised.number = 3;
  localised.recorded_camera.emplace();
  localised.recorded_camera->lens = {400, 401, 320, 240, RadialTangential{-0.1, 0.01, 0, 0, 0}};
  localised.tracked_frames = {{4, {{0xa}, 7}, {Eigen::Quaterniond::Identity(), {0.5, 0, 0}}},
                              {5, {{0xb}, 0}, {Eigen::Quaterniond::Identity(), {0, 0.25, 0}}}};
  localised.lost_frames_ns = {6, 9};
  return localised;
}

std::string ErrorAfter(const std::function<void(v1::LocalisedFrames&)>& change) {
  v1::LocalisedFrames proto;
  ToProto(MakeLocalised(), &proto);
  change(proto);
  const absl::Status status = FromProto(proto).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  return std::string(status.message());
}

TEST(LocalisedFramesTest, AllOfItComesBack) {
  const LocalisedFrames sent = MakeLocalised();
  v1::LocalisedFrames proto;
  ToProto(sent, &proto);
  const auto read = FromProto(proto);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->frames.size(), 2u);
  EXPECT_EQ(read->frames[0].camera_from_global->translation,
            sent.frames[0].camera_from_global->translation);
  EXPECT_FALSE(read->frames[1].camera_from_global.has_value());
  EXPECT_EQ(read->run, sent.run);
  EXPECT_EQ(read->number, 3u);
  EXPECT_EQ(read->recorded_camera, sent.recorded_camera);
  ASSERT_EQ(read->tracked_frames.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read->tracked_frames[i].timestamp_ns, sent.tracked_frames[i].timestamp_ns);
    EXPECT_EQ(read->tracked_frames[i].reference, sent.tracked_frames[i].reference);
    EXPECT_EQ(read->tracked_frames[i].reference_from_camera.translation,
              sent.tracked_frames[i].reference_from_camera.translation);
  }
  EXPECT_EQ(read->lost_frames_ns, sent.lost_frames_ns);
}

// As agents of before say it.
TEST(LocalisedFramesTest, WithoutARunThereIsNothingToKeep) {
  LocalisedFrames sent = MakeLocalised();
  sent.run = 0;
  v1::LocalisedFrames proto;
  ToProto(sent, &proto);
  EXPECT_EQ(proto.tracked_frames().timestamp_deltas_ns_size(), 0);
  proto.mutable_tracked_frames()->add_timestamp_deltas_ns(1);
  const auto read = FromProto(proto);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->frames.size(), 2u);
  EXPECT_TRUE(read->tracked_frames.empty());
}

TEST(LocalisedFramesTest, WhatCannotBeIsRefusedWithItsName) {
  EXPECT_THAT(ErrorAfter([](auto& proto) { proto.set_number(0); }), HasSubstr("number is 0"));
  EXPECT_THAT(ErrorAfter([](auto& proto) { proto.set_local_maps(0, 0); }),
              HasSubstr("part 3 of run fedcba9876543210"));
  EXPECT_THAT(ErrorAfter([](auto& proto) {
                proto.mutable_tracked_frames()->mutable_reference_from_camera()->RemoveLast();
              }),
              HasSubstr("reference_from_camera"));
  EXPECT_THAT(ErrorAfter([](auto& proto) { proto.set_lost_frame_deltas_ns(0, -1); }),
              HasSubstr("lost_frame_deltas_ns"));
  EXPECT_THAT(ErrorAfter([](auto& proto) {
                for (int i = 0; i < kMaxLocalisedFrames; ++i) proto.add_lost_frame_deltas_ns(1);
              }),
              HasSubstr("tracked and lost frames"));
}

}  // namespace
}  // namespace corbslam::services
