#include "services/tool/export/mcap/mission_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "foxglove/frames.pb.h"
#include "foxglove/log.pb.h"
#include "foxglove/point_cloud.pb.h"
#include "foxglove/scene.pb.h"
#include "services/testing/test_path.h"
#include "services/tool/export/mcap/frame_names.h"
#include "services/tool/export/mcap/island_layout.h"
#include "services/tool/export/mcap/testing/made_up_mission.h"
#include "services/tool/export/mcap/testing/mcap_reader.h"

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kAlphas;
using testing::kHostiles;
using testing::MadeUpMission;
using testing::MakeUpMission;
using testing::McapFile;
using testing::ReadMcap;
using ::testing::SizeIs;

// What the hostile robot is called in topics and frames.
constexpr char kEscaped[] = "b%22%2F%0A%FF%C3%25";

McapFile RecordAndRead(const MadeUpMission& made_up) {
  const std::string path = TestPath("a.mcap");
  const absl::Status status = testing::Record(made_up, path);
  EXPECT_TRUE(status.ok()) << status;
  const auto file = ReadMcap(path);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *file : McapFile();
}

template <typename Message>
std::vector<Message> Decode(const McapFile& file, const std::string& topic) {
  std::vector<Message> messages;
  for (const McapFile::Message& message : file.On(topic)) {
    EXPECT_EQ(message.schema, Message::descriptor()->full_name());
    EXPECT_TRUE(messages.emplace_back().ParseFromString(message.data)) << topic;
  }
  return messages;
}

TEST(FrameNamesTest, DifferentNamesStayDifferent) {
  EXPECT_EQ(EscapeName("alpha-1_b.c"), "alpha-1_b.c");
  EXPECT_EQ(EscapeName(testing::kHostileName), kEscaped);
  EXPECT_EQ(EscapeName(""), "%");
  EXPECT_EQ(EscapeName("%"), "%25");
  EXPECT_EQ(EscapeText("it's 5 %\n\xff"), "it's 5 %%0A%FF");
}

TEST(IslandLayoutTest, IslandsStandClearOfEachOther) {
  ToldMap::Islands islands;
  const auto add = [&](uint64_t id, double from, double to) {
    ToldMap::Island& island = islands[LocalMapId{id}];
    island.keyframes[{LocalMapId{id}, 0}].island_from_camera.translation.x() = from;
    island.keyframes[{LocalMapId{id}, 1}].island_from_camera.translation.x() = to;
  };
  add(1, -20, 10);
  add(2, -5, 5);
  add(3, 0, 0);
  islands[LocalMapId{2}].in_global_frame = true;
  islands[LocalMapId{4}];
  const auto places = PlaceIslands(islands);
  EXPECT_EQ(places.at(LocalMapId{2}).x(), 0) << "the global frame is the mission's";
  EXPECT_EQ(places.at(LocalMapId{1}).x() - 20, 5 + 6);
  EXPECT_EQ(places.at(LocalMapId{3}).x(), 41 + 1);
  EXPECT_EQ(places.at(LocalMapId{4}).x(), 42 + 1) << "an island without keyframes";
}

TEST(MissionRecordingTest, TellsThePastASecondAMoment) {
  const McapFile file = RecordAndRead(MakeUpMission());
  const auto frusta = file.On("/map/alpha/keyframes");
  ASSERT_THAT(frusta, SizeIs(3));
  for (uint64_t i = 0; i < 3; ++i) EXPECT_EQ(frusta[i].time_ns, (i + 1) * 1'000'000'000);
  const auto scenes = Decode<foxglove::SceneUpdate>(file, "/map/alpha/keyframes");
  for (const foxglove::SceneUpdate& scene : scenes) {
    ASSERT_EQ(scene.deletions_size(), 1);
    EXPECT_EQ(scene.deletions(0).type(), foxglove::SceneEntityDeletion::ALL);
    ASSERT_EQ(scene.entities_size(), 1);
    EXPECT_EQ(scene.entities(0).frame_id(), "island/00000000000000a1");
    EXPECT_EQ(scene.entities(0).lines(0).points_size(), 4 * 5);
    EXPECT_EQ(scene.entities(0).lines(0).indices_size(), 4 * 16);
    // Keyframes are 2 m apart: frusta are 1 m deep.
    EXPECT_DOUBLE_EQ(scene.entities(0).lines(0).points(1).z(), 1.0);
  }
  const auto trees = Decode<foxglove::SceneUpdate>(file, "/map/alpha/tree");
  EXPECT_EQ(trees.back().entities(0).lines(0).points_size(), 3 * 2);
}

TEST(MissionRecordingTest, IslandsAreApartUntilTheyAreOne) {
  const McapFile file = RecordAndRead(MakeUpMission());
  const auto frames = Decode<foxglove::FrameTransforms>(file, "/frames");
  ASSERT_THAT(frames, SizeIs(3));
  ASSERT_EQ(frames[1].transforms_size(), 3);
  EXPECT_EQ(frames[1].transforms(0).parent_frame_id(), "upright");
  EXPECT_EQ(frames[1].transforms(1).parent_frame_id(), "mission");
  EXPECT_EQ(frames[1].transforms(1).child_frame_id(), "island/00000000000000a1");
  EXPECT_EQ(frames[1].transforms(1).translation().x(), 0);
  EXPECT_EQ(frames[1].transforms(2).child_frame_id(), "island/00000000000000b2");
  EXPECT_EQ(frames[2].transforms_size(), 2);
  const auto scenes =
      Decode<foxglove::SceneUpdate>(file, MapTopic(testing::kHostileName, "keyframes"));
  EXPECT_EQ(scenes[1].entities(0).frame_id(), "island/00000000000000b2");
  EXPECT_EQ(scenes[2].entities(0).frame_id(), "island/00000000000000a1");
}

TEST(MissionRecordingTest, OverlapsAreDrawnOnceARevisionHasThem) {
  const auto scenes =
      Decode<foxglove::SceneUpdate>(RecordAndRead(MakeUpMission()), "/map/overlaps");
  ASSERT_THAT(scenes, SizeIs(3));
  EXPECT_EQ(scenes[0].entities_size(), 0);
  EXPECT_EQ(scenes[1].entities_size(), 0);
  ASSERT_EQ(scenes[2].entities_size(), 1);
  ASSERT_EQ(scenes[2].entities(0).lines(0).points_size(), 2) << "not the one of no revision";
  EXPECT_EQ(scenes[2].entities(0).lines(0).points(1).x(), 3);
}

TEST(MissionRecordingTest, HasThePointsAsTheyAre) {
  const McapFile file = RecordAndRead(MakeUpMission());
  const auto clouds = Decode<foxglove::PointCloud>(file, MapTopic(testing::kHostileName, "points"));
  ASSERT_THAT(clouds, SizeIs(1));
  ASSERT_EQ(clouds[0].point_stride(), 16u);
  ASSERT_EQ(clouds[0].data().size(), 50u * 16);
  ASSERT_EQ(clouds[0].fields_size(), 7);
  EXPECT_EQ(clouds[0].fields(6).offset(), 15u);
  float position[3];
  std::memcpy(position, clouds[0].data().data() + 2 * 16, sizeof(position));
  EXPECT_THAT(position, ElementsAre(3.5F, 0.5F, 1.5F));
  const Colour colour = MakeUpMission().mission.colours.at(testing::kHostileName);
  EXPECT_EQ(static_cast<uint8_t>(clouds[0].data()[12]), colour.red);
  EXPECT_EQ(static_cast<uint8_t>(clouds[0].data()[15]), 255);
}

TEST(MissionRecordingTest, RobotsDriveBehindThePastByTheirOwnClocks) {
  const McapFile file = RecordAndRead(MakeUpMission());
  for (const std::string robot : {"alpha", testing::kHostileName}) {
    const auto paths = Decode<foxglove::PosesInFrame>(file, RobotTopic(robot, "trajectory"));
    ASSERT_THAT(paths, SizeIs(1));
    EXPECT_EQ(paths[0].poses_size(), 10);
    // Nothing is drawn where tracking was lost.
    const auto ways = Decode<foxglove::SceneUpdate>(file, RobotTopic(robot, "way"));
    ASSERT_THAT(ways, SizeIs(1));
    ASSERT_EQ(ways[0].entities_size(), 1);
    ASSERT_EQ(ways[0].entities(0).lines_size(), 2);
    EXPECT_EQ(ways[0].entities(0).lines(0).points_size(), 4);
    EXPECT_EQ(ways[0].entities(0).lines(1).points_size(), 6);
    const auto poses = Decode<foxglove::FrameTransform>(file, RobotTopic(robot, "pose"));
    ASSERT_THAT(poses, SizeIs(10));
    EXPECT_EQ(poses[0].timestamp().seconds(), 4);
    EXPECT_EQ(poses[3].timestamp().nanos(), 300'000'000);
    EXPECT_EQ(poses[3].child_frame_id(), "camera/" + EscapeName(robot));
    EXPECT_DOUBLE_EQ(poses[3].translation().z(), 1.8);
  }
  EXPECT_EQ(file.last_ns, 4'900'000'000u);
  EXPECT_TRUE(std::is_sorted(file.messages.begin(), file.messages.end(),
                             [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; }));
  EXPECT_EQ(file.metadata.at("corbslam").at("first_frame_ns/alpha"), "1403636579763555584");
}

// Two robots with one clock, whose keyframes were taken every half second.
MadeUpMission MakeUpOnRobotsClock() {
  MadeUpMission made_up = MakeUpMission();
  constexpr int64_t kBegin_ns = 1'403'636'579'000'000'000;
  made_up.mission.clock = RecordingClock::kRobots;
  for (uint32_t i = 0; i < 4; ++i) {
    made_up.mission.keyframe_times_ns[{kAlphas, i}] = kBegin_ns + i * 200'000'000;
  }
  for (size_t robot = 0; robot < 2; ++robot) {
    RecordedTrajectory& trajectory = made_up.trajectories[robot];
    trajectory.drive_begins_ns = kBegin_ns + static_cast<int64_t>(robot) * 50'000'000;
    for (size_t i = 0; i < trajectory.poses.size(); ++i) {
      trajectory.poses[i].timestamp_ns =
          trajectory.drive_begins_ns + static_cast<int64_t>(i) * 100'000'000;
    }
  }
  // The first moment knows two keyframes.
  auto& first = made_up.moments[0].islands[kAlphas].keyframes;
  first.erase({kAlphas, 2});
  first.erase({kAlphas, 3});
  return made_up;
}

TEST(MissionRecordingTest, OnTheRobotsClockPosesHaveTheirFramesTimes) {
  const MadeUpMission made_up = MakeUpOnRobotsClock();
  const McapFile file = RecordAndRead(made_up);
  for (const RecordedTrajectory& trajectory : made_up.trajectories) {
    const auto poses = file.On(RobotTopic(trajectory.robot, "pose"));
    ASSERT_THAT(poses, SizeIs(10));
    for (size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(poses[i].time_ns, static_cast<uint64_t>(trajectory.poses[i].timestamp_ns));
    }
    ASSERT_THAT(file.On(RobotTopic(trajectory.robot, "trajectory")), SizeIs(1));
  }
  const auto keyframes = file.On("/map/alpha/keyframes");
  ASSERT_THAT(keyframes, SizeIs(3));
  EXPECT_EQ(keyframes[0].time_ns, 1'403'636'579'200'000'000u);
  EXPECT_EQ(keyframes[1].time_ns, 1'403'636'579'600'000'000u);
  EXPECT_EQ(keyframes[2].time_ns, 1'403'636'579'600'000'000u);
  EXPECT_TRUE(std::is_sorted(file.messages.begin(), file.messages.end(),
                             [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; }));
  EXPECT_THAT(file.metadata.at("corbslam").at("clock"), HasSubstr("robots' own"));
}

TEST(MissionRecordingTest, OnTheRobotsClockPointsComeAsTheyCame) {
  const McapFile file = RecordAndRead(MakeUpOnRobotsClock());
  const auto clouds = file.On("/map/alpha/points");
  // At each moment, and as they are in the end.
  ASSERT_THAT(clouds, SizeIs(4));
  EXPECT_EQ(clouds[0].time_ns, 1'403'636'579'200'000'000u);
}

TEST(MissionRecordingTest, NoTimeIsBeforeZero) {
  MadeUpMission early = MakeUpOnRobotsClock();
  early.trajectories[0].drive_begins_ns = -5;
  const absl::Status status = testing::Record(early, TestPath("a.mcap"));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no time before 0"));
}

TEST(MissionRecordingTest, NotesComeWithTheirRevisionAndInTheEnd) {
  const auto notes = Decode<foxglove::Log>(RecordAndRead(MakeUpMission()), "/log");
  std::vector<std::string> texts;
  for (const foxglove::Log& note : notes) texts.push_back(note.message());
  EXPECT_THAT(texts,
              ElementsAre(HasSubstr("revision 0: 8 keyframes, 2 islands"), HasSubstr("revision 1"),
                          HasSubstr("lost %FF%0Ab\"/%0A"),
                          HasSubstr("revision 5: 8 keyframes, 1 island"), "overlap 1: accepted",
                          HasSubstr("refused, the scales disagree"), HasSubstr("drive again")));
  EXPECT_EQ(notes[2].level(), foxglove::Log::WARNING);
  EXPECT_EQ(notes[2].timestamp().seconds(), 2);
}

TEST(MissionRecordingTest, NothingIsHardToRecord) {
  const McapFile empty = RecordAndRead(MadeUpMission());
  EXPECT_THAT(empty.On("/log"), SizeIs(1));
  MadeUpMission pointless = MakeUpMission();
  for (ToldMap& map : pointless.moments) {
    for (auto& [id, island] : map.islands) island.points.clear();
  }
  EXPECT_THAT(RecordAndRead(pointless).On("/map/alpha/points"), SizeIs(0));
  MadeUpMission still = MakeUpMission();
  still.moments.resize(1);
  still.moments[0].islands[kAlphas].keyframes.clear();
  still.moments[0].islands[kHostiles].keyframes.clear();
  still.trajectories.clear();
  EXPECT_EQ(
      Decode<foxglove::SceneUpdate>(RecordAndRead(still), "/map/alpha/tree")[0].entities_size(), 0);
}

TEST(MissionRecordingTest, RefusesTrajectoriesThatFitNoMap) {
  MadeUpMission elsewhere = MakeUpMission();
  elsewhere.trajectories[1].island = LocalMapId{0xdead};
  const std::string path = TestPath("a.mcap");
  absl::Status status = testing::Record(elsewhere, path);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("000000000000dead"));
  MadeUpMission backwards = MakeUpMission();
  std::swap(backwards.trajectories[0].poses[2], backwards.trajectories[0].poses[3]);
  status = testing::Record(backwards, path);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("robot alpha"));
  EXPECT_FALSE(std::filesystem::exists(path)) << "no half of a recording";
}

TEST(MissionRecordingTest, AMillionPointsGoInPieces) {
  MadeUpMission large = MakeUpMission();
  auto& points = large.moments.back().islands[kAlphas].points;
  for (uint32_t i = 0; i < 1'000'000; ++i) {
    points[{kAlphas, i}] = {static_cast<float>(i), 0, 1};
  }
  const ToldMap end = large.moments.back();
  const std::string path = TestPath("large.mcap");
  auto recording = MissionRecording::Create(path, large.mission);
  ASSERT_TRUE(recording.ok()) << recording.status();
  ASSERT_TRUE(recording->End(end, large.trajectories).ok());
  ASSERT_TRUE(recording->Finish().ok());
  const auto file = ReadMcap(path);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(*std::max_element(file->chunk_bytes.begin(), file->chunk_bytes.end()) / 1'000'000, 8u);
  size_t count = 0;
  for (const char* topic : {"/map/alpha/points", "/map/alpha/points+2"}) {
    for (const foxglove::PointCloud& cloud : Decode<foxglove::PointCloud>(*file, topic)) {
      count += cloud.data().size() / 16;
    }
  }
  EXPECT_EQ(count, 1'000'000u);
}

}  // namespace
}  // namespace corbslam::services
