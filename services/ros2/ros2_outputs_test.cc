#include "services/ros2/ros2_outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ros2_types.h>

#include <atomic>
#include <cstring>

#include "client_agent/live/ros2/testing/ros2_driver.h"

namespace corbslam::services {
namespace {

using client_agent::kDefaultQos;
using client_agent::kLatched;
using client_agent::Nanoseconds;
using client_agent::NearMap;
using client_agent::Ros2Names;
using client_agent::Ros2Node;
using client_agent::Ros2Settings;
using client_agent::TestNode;
using client_agent::Within10s;

constexpr int64_t kStamp_ns = 1'600'000'000'123'456'789;

class Ros2OutputsTest : public ::testing::Test {
 protected:
  // Makes the outputs and waits until somebody who listens to `topic` is known to them.
  template <typename Message>
  void Listen(const std::string& topic, const dds_topic_descriptor_t& type,
              std::function<void(const Message&)> handler) {
    const auto subscription = listener_->Subscribe(
        "rt" + topic, type, kDefaultQos,
        [handler](const void* sample) { handler(*static_cast<const Message*>(sample)); });
    ASSERT_TRUE(subscription.ok()) << subscription.status();
    ASSERT_TRUE(Within10s([&] { return (*subscription)->Hearing().publishers > 0; }));
  }
  void SetUp() override {
    auto outputs = Ros2Outputs::Make(*Ros2Names::Make("visual_slam", {}), settings_, *talker_);
    ASSERT_TRUE(outputs.ok()) << outputs.status();
    outputs_ = *std::move(outputs);
  }
  void TearDown() override { listener_->Stop(); }

  static Ros2Poses Poses() {
    Ros2Poses poses;
    poses.timestamp_ns = kStamp_ns;
    poses.odom_from_base = Rigid3d{Eigen::Quaterniond(0, 0, 0, 1), {1, 2, 3}};
    poses.map_from_base = Rigid3d{Eigen::Quaterniond::Identity(), {4, 5, 6}};
    poses.velocity = Vector6d::Constant(0.5);
    return poses;
  }

  Ros2Settings settings_;
  std::unique_ptr<Ros2Node> talker_ = *Ros2Node::Create(TestNode("talker"));
  std::unique_ptr<Ros2Node> listener_ = *Ros2Node::Create(TestNode("listener"));
  std::unique_ptr<Ros2Outputs> outputs_;
};

TEST_F(Ros2OutputsTest, OdometrySaysWhatIsNotKnown) {
  using Odometry = nav_msgs_msg_dds__Odometry_;
  std::atomic<int> heard = 0;
  Listen<Odometry>("/visual_slam/tracking/odometry", nav_msgs_msg_dds__Odometry__desc,
                   [&](const Odometry& message) {
                     EXPECT_EQ(Nanoseconds(message.header.stamp), kStamp_ns);
                     EXPECT_STREQ(message.header.frame_id, "odom");
                     EXPECT_STREQ(message.child_frame_id, "base_link");
                     EXPECT_EQ(message.pose.pose.position.z, 3);
                     EXPECT_EQ(message.pose.pose.orientation.z, 1);
                     EXPECT_EQ(message.pose.covariance[7], Ros2Outputs::kUnknownVariance);
                     EXPECT_EQ(message.pose.covariance[1], 0);
                     EXPECT_EQ(message.twist.twist.angular.z, 0.5);
                     ++heard;
                   });
  outputs_->PublishPoses(Poses());
  EXPECT_TRUE(Within10s([&] { return heard == 1; }));
}

TEST_F(Ros2OutputsTest, TransformsOfOneInstantComeTogether) {
  using Transforms = tf2_msgs_msg_dds__TFMessage_;
  std::atomic<int> heard = 0;
  Listen<Transforms>("/tf", tf2_msgs_msg_dds__TFMessage__desc, [&](const Transforms& message) {
    ASSERT_EQ(message.transforms._length, 2u);
    const auto& odom = message.transforms._buffer[0];
    const auto& map = message.transforms._buffer[1];
    EXPECT_EQ(Nanoseconds(odom.header.stamp), kStamp_ns);
    EXPECT_EQ(Nanoseconds(map.header.stamp), kStamp_ns);
    EXPECT_STREQ(map.header.frame_id, "map");
    EXPECT_STREQ(map.child_frame_id, odom.header.frame_id);
    EXPECT_STREQ(odom.child_frame_id, "base_link");
    // Half a turn about z, then back.
    EXPECT_NEAR(map.transform.translation.x, 4 + 1, 1e-12);
    EXPECT_NEAR(map.transform.translation.y, 5 + 2, 1e-12);
    ++heard;
  });
  outputs_->PublishPoses(Poses());
  EXPECT_TRUE(Within10s([&] { return heard == 1; }));
}

TEST_F(Ros2OutputsTest, APoseWithoutCovarianceIsNotToldWithOne) {
  using Pose = geometry_msgs_msg_dds__PoseWithCovarianceStamped_;
  std::atomic<int> heard = 0;
  Listen<Pose>("/visual_slam/tracking/vo_pose_covariance",
               geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, [&](const Pose& message) {
                 EXPECT_STREQ(message.header.frame_id, "map");
                 EXPECT_EQ(message.pose.covariance[35], 2);
                 ++heard;
               });
  outputs_->PublishPoses(Poses());
  Ros2Poses sure = Poses();
  sure.map_covariance = 2 * Matrix6d::Identity();
  outputs_->PublishPoses(sure);
  EXPECT_TRUE(Within10s([&] { return heard == 1; }));
}

TEST_F(Ros2OutputsTest, TheCloudIsOfTheMap) {
  using Cloud = sensor_msgs_msg_dds__PointCloud2_;
  std::atomic<int> heard = 0;
  Listen<Cloud>("/visual_slam/vis/landmarks_cloud", sensor_msgs_msg_dds__PointCloud2__desc,
                [&](const Cloud& message) {
                  ASSERT_EQ(message.width, 2u);
                  ASSERT_EQ(message.data._length, 32u);
                  float values[8];
                  std::memcpy(values, message.data._buffer, sizeof(values));
                  EXPECT_THAT(values, ::testing::ElementsAre(11, 2, 3, 0, 14, 5, 6, 1));
                  EXPECT_STREQ(message.fields._buffer[3].name, "intensity");
                  ++heard;
                });
  NearMap near;
  near.timestamp_ns = kStamp_ns;
  near.own_points = {{1, 2, 3}};
  near.shared_points = {{4, 5, 6}};
  outputs_->PublishCloud(near, {1, Eigen::Quaterniond::Identity(), {10, 0, 0}});
  EXPECT_TRUE(Within10s([&] { return heard == 1; }));
}

TEST_F(Ros2OutputsTest, DiagnosticsNameTheNode) {
  using Diagnostics = diagnostic_msgs_msg_dds__DiagnosticArray_;
  std::atomic<int> heard = 0;
  Listen<Diagnostics>("/diagnostics", diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                      [&](const Diagnostics& message) {
                        ASSERT_EQ(message.status._length, 2u);
                        EXPECT_STREQ(message.status._buffer[1].name, "visual_slam: camera");
                        EXPECT_EQ(message.status._buffer[1].level, 2);
                        EXPECT_STREQ(message.status._buffer[0].values._buffer[0].value, "7");
                        ++heard;
                      });
  outputs_->PublishDiagnoses(
      {{Ros2Diagnosis::Level::kOk, "tracking", "tracking", {{"frames", "7"}}},
       {Ros2Diagnosis::Level::kError, "camera", "gone", {}}},
      kStamp_ns, "alpha");
  EXPECT_TRUE(Within10s([&] { return heard == 1; }));
}

}  // namespace
}  // namespace corbslam::services
