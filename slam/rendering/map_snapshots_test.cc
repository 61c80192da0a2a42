#include "slam/rendering/map_snapshots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

MapPicture MakeStreet(const std::string& robot, int keyframes) {
  MapPicture map;
  map.title = robot;
  map.robots = {{robot, robot == "alpha", {}, {}}};
  for (int i = 0; i < keyframes; ++i) {
    Rigid3d pose;
    pose.translation = {0.01 * i * i, 0, 2.0 * i};
    map.robots[0].keyframes.push_back(pose);
    map.points.push_back(pose.translation + Eigen::Vector3d(4, 0, 1));
  }
  return map;
}

// Two islands, then one.
std::vector<MapSnapshot> MakePast() {
  MapSnapshot early{"revision 1",
                    {{7, true, MakeStreet("alpha", 5)}, {9, false, MakeStreet("bravo", 8)}}};
  MapSnapshot late{"revision 4", {{7, true, MakeStreet("alpha", 12)}}};
  late.islands[0].map.robots.push_back(MakeStreet("bravo", 10).robots[0]);
  return {early, late};
}

TEST(RenderSnapshotsTest, DrawsIslandsApartUntilTheyAreFused) {
  const absl::StatusOr<std::string> svg = RenderSnapshotsSvg(MakePast());
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, AllOf(HasSubstr(">revision 1</text>"), HasSubstr(">revision 4</text>"),
                          HasSubstr(">alpha</text>"), HasSubstr(">bravo</text>"),
                          HasSubstr("#28a03c"), HasSubstr("#145ad2")));
  const absl::StatusOr<cv::Mat> image = RenderSnapshots(MakePast());
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(image->cols, 1200);
}

TEST(RenderSnapshotsTest, RefusesWhatCantBeDrawn) {
  EXPECT_EQ(RenderSnapshots({}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(RenderSnapshots({MapSnapshot{"empty", {{1, true, {}}}}}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(RenderSnapshotsSvg(MakePast(), {100}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(RenderFrameTest, AllFramesHaveOneSize) {
  SnapshotStage stage;
  for (const MapSnapshot& snapshot : MakePast()) stage.Observe(snapshot);
  std::vector<cv::Size> sizes;
  for (const MapSnapshot& snapshot : MakePast()) {
    const absl::StatusOr<cv::Mat> frame = RenderFrame(stage, snapshot, {400});
    ASSERT_TRUE(frame.ok()) << frame.status();
    sizes.push_back(frame->size());
  }
  EXPECT_EQ(sizes[0], sizes[1]);
}

TEST(SnapshotStageTest, CountsIslandsThatHaveNoRoom) {
  MapSnapshot snapshot{"revision 2", {}};
  for (uint64_t id = 1; id <= 9; ++id)
    snapshot.islands.push_back({id, false, MakeStreet("alpha", 3)});
  const absl::StatusOr<std::string> svg = RenderSnapshotsSvg({snapshot});
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, HasSubstr("revision 2, 3 more islands not drawn"));
}

}  // namespace
}  // namespace corbslam
