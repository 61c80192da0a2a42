#include "services/tool/evaluation/trajectory_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "services/testing/test_path.h"
#include "slam/evaluation/trajectory_file.h"

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;

void AddPoses(const std::string& local_map, std::initializer_list<int64_t> times_ns,
              ServedTrajectory& served) {
  for (const int64_t time_ns : times_ns) served.push_back({time_ns, Rigid3d(), local_map});
}

std::vector<std::vector<int64_t>> TimesOf(const std::vector<TrajectoryFile>& files) {
  std::vector<std::vector<int64_t>> times;
  for (const TrajectoryFile& file : files) {
    times.emplace_back();
    for (const StampedPose& pose : Join(file)) times.back().push_back(pose.timestamp_ns);
  }
  return times;
}

TEST(TrajectoryFilesTest, LocalMapsThatFollowEachOtherShareAFile) {
  ServedTrajectory served;
  AddPoses("b", {5, 6}, served);
  AddPoses("a", {1, 2, 3}, served);
  const std::vector<TrajectoryFile> files = ShareFiles(PartsOf(served));
  EXPECT_THAT(TimesOf(files), ElementsAre(ElementsAre(1, 2, 3, 5, 6)));
  EXPECT_THAT(DescribeParts(files[0]),
              ElementsAre("local map a: poses 1 to 3", "local map b: poses 4 to 5"));
  EXPECT_THAT(TimesOf(OwnFiles(PartsOf(served))),
              ElementsAre(ElementsAre(1, 2, 3), ElementsAre(5, 6)));
}

TEST(TrajectoryFilesTest, ARobotThatWasStartedAgainHasAnotherFile) {
  ServedTrajectory served;
  AddPoses("a", {1, 2, 3}, served);
  AddPoses("b", {1, 2, 3}, served);
  AddPoses("c", {3, 4}, served);
  AddPoses("d", {9}, served);
  EXPECT_THAT(TimesOf(ShareFiles(PartsOf(served))),
              ElementsAre(ElementsAre(1, 2, 3, 9), ElementsAre(1, 2, 3), ElementsAre(3, 4)));
}

// A run that only localised; a local map's poses lie in one island.
TEST(TrajectoryFilesTest, PosesInDifferentFramesAreApart) {
  ServedTrajectory served;
  AddPoses("localised-1", {1, 2, 5, 6}, served);
  served[0].island = served[1].island = "a";
  served[2].island = served[3].island = "b";
  const std::vector<TrajectoryPart> parts = PartsOf(served);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].island, "a");
  EXPECT_EQ(parts[1].island, "b");
  EXPECT_EQ(parts[1].poses.size(), 2u);
  EXPECT_THAT(TimesOf(ShareFiles(parts)), ElementsAre(ElementsAre(1, 2, 5, 6)));
}

TEST(TrajectoryFilesTest, TimesAscendWithinALocalMap) {
  ServedTrajectory served;
  AddPoses("a", {3, 1, 3, 2}, served);
  EXPECT_THAT(TimesOf(ShareFiles(PartsOf(served))), ElementsAre(ElementsAre(1, 2, 3)));
}

TEST(TrajectoryFilesTest, NothingIsAnEmptyFile) {
  EXPECT_THAT(TimesOf(ShareFiles({})), ElementsAre(ElementsAre()));
  EXPECT_THAT(TimesOf(OwnFiles({})), ElementsAre(ElementsAre()));
}

TEST(TrajectoryFilesTest, NumbersStandBeforeTheEnding) {
  EXPECT_THAT(SuffixedPaths("out/alpha.local.tum", {"", "+2"}),
              ElementsAre("out/alpha.local.tum", "out/alpha.local+2.tum"));
  EXPECT_THAT(SuffixedPaths("out.d/alpha", {"+3"}), ElementsAre("out.d/alpha+3"));
}

// As `mission show` calls them.
TEST(TrajectoryFilesTest, FilesAreCalledAfterTheirFirstLocalMap) {
  const auto part = [](const std::string& id) { return TrajectoryPart{id, {}}; };
  const std::vector<TrajectoryFile> files = {
      {part("a"), part("b")}, {part("e"), part("d")}, {part("x")}, {part("c")}, {part("y")}};
  const LocalMapNames names = {{"a", "alpha/1"}, {"b", "alpha/2"}, {"c", "alpha/3"},
                               {"d", "alpha/4"}, {"e", "alpha/6"}, {"x", "alpha/5"}};
  EXPECT_THAT(SuffixesOf(files, names), ElementsAre("", "+4", "+5", "+3", "+5b"));
  EXPECT_THAT(SuffixedPaths("out/alpha.txt", {"", "+4"}),
              ElementsAre("out/alpha.txt", "out/alpha+4.txt"));
  EXPECT_THAT(DescribeParts({{"d", {{1, {}}}}}, names),
              ElementsAre("local map alpha/4, d: poses 1 to 1"));
  EXPECT_THAT(SuffixesOf(files, {}), ElementsAre("", "+2", "+3", "+4", "+5"));
}

TEST(TrajectoryFilesTest, FilesSayWhatTheyHold) {
  ServedTrajectory served;
  AddPoses("a", {1, 2}, served);
  AddPoses("b", {1}, served);
  const std::string path = TestPath("poses.tum");
  const std::vector<TrajectoryFile> files = ShareFiles(PartsOf(served));
  const std::vector<std::string> paths = SuffixedPaths(path, SuffixesOf(files, {}));
  ASSERT_TRUE(WriteTumFiles(files, PosesOf::kBody, "in some frame", paths, {}).ok());
  const auto first = ReadTrajectoryFile(path);
  const auto second = ReadTrajectoryFile(paths.at(1));
  ASSERT_TRUE(first.ok() && second.ok()) << first.status() << second.status();
  EXPECT_EQ(first->trajectory.size(), 2u);
  EXPECT_EQ(second->trajectory.size(), 1u);
  EXPECT_EQ(first->poses_of, PosesOf::kBody);
}

}  // namespace
}  // namespace corbslam::services
