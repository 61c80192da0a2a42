#include "services/agent_service/near_map_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

namespace corbslam::services {
namespace {

using client_agent::NearMap;
using ::testing::HasSubstr;

NearMap MakeNearMap() {
  NearMap near;
  near.local_map = LocalMapId{0xabc};
  near.timestamp_ns = 5;
  near.centre = {1, 2, 3};
  near.own_points = {{1, 0, 0}, {2, 0, 0}};
  near.shared_points = {{0, 0.5, 0}};
  Rigid3d pose;
  pose.translation = {4, 5, 6};
  near.keyframes = {{{LocalMapId{0xabc}, 7}, pose, false}, {{LocalMapId{0xdef}, 8}, pose, true}};
  near.truncated = true;
  return near;
}

TEST(NearMapMessageTest, ComesBackAsItWas) {
  const NearMap near = MakeNearMap();
  v1::WatchAgentMapResponse proto;
  ToProto(near, &proto);
  EXPECT_EQ(proto.local_map(), "0000000000000abc");
  const absl::StatusOr<NearMap> read = FromProto(proto);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->local_map, near.local_map);
  EXPECT_EQ(read->timestamp_ns, 5);
  EXPECT_EQ(read->centre, near.centre);
  EXPECT_EQ(read->own_points, near.own_points);
  EXPECT_EQ(read->shared_points, near.shared_points);
  EXPECT_TRUE(read->truncated);
  ASSERT_EQ(read->keyframes.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read->keyframes[i].id, near.keyframes[i].id);
    EXPECT_EQ(read->keyframes[i].shared, near.keyframes[i].shared);
    EXPECT_EQ(read->keyframes[i].local_from_camera.translation, Eigen::Vector3d(4, 5, 6));
  }
}

TEST(NearMapMessageTest, RefusesWhatIsNoMapAndNamesIt) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const struct {
    std::string complaint;
    std::function<void(v1::WatchAgentMapResponse&)> spoil;
  } cases[] = {
      {"local_map is \"xyz\"", [](auto& proto) { proto.set_local_map("xyz"); }},
      {"local_map is \"\"", [](auto& proto) { proto.clear_local_map(); }},
      {"centre has 4 numbers", [](auto& proto) { proto.add_centre(1); }},
      {"own_points has 7 numbers", [](auto& proto) { proto.add_own_points(1); }},
      {"shared_points[0] is not finite", [](auto& proto) { proto.set_shared_points(2, kNaN); }},
      {"keyframes[1]: local_map is \"0000000000000000\"",
       [](auto& proto) { proto.mutable_keyframes(1)->set_local_map("0000000000000000"); }},
      {"keyframes[0]", [](auto& proto) { proto.mutable_keyframes(0)->clear_local_from_camera(); }}};
  for (const auto& [complaint, spoil] : cases) {
    v1::WatchAgentMapResponse proto;
    ToProto(MakeNearMap(), &proto);
    spoil(proto);
    const absl::Status status = FromProto(proto).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << complaint;
    EXPECT_THAT(std::string(status.message()), HasSubstr(complaint));
  }
}

}  // namespace
}  // namespace corbslam::services
