#include "services/convert/resource_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(ResourceNamesTest, AreReadAsTheyAreWritten) {
  const KeyframeId id{{0xc0ffee}, 12};
  EXPECT_EQ(KeyframeName("m", id), "missions/m/localMaps/0000000000c0ffee/keyframes/12");
  EXPECT_EQ(ParseKeyframeName(KeyframeName("m", id))->keyframe, id);
  EXPECT_EQ(ParseLocalMapName(LocalMapName("m.2", id.local_map), false)->local_map, id.local_map);
  EXPECT_EQ(ParseMissionName(MissionName("a-b_c"))->c_str(), std::string("a-b_c"));
  EXPECT_EQ(ParseAgentName(AgentName("m", "alpha"), false)->agent, "alpha");
  EXPECT_EQ(OverlapName("m", 7), "missions/m/overlaps/7");
  EXPECT_EQ(ParseOverlapName(OverlapName("m", 7))->overlap, 7u);
}

TEST(ResourceNamesTest, ADashMeansAllWhereThatIsAllowed) {
  EXPECT_EQ(ParseAgentName("missions/m/agents/-", true)->agent, "");
  EXPECT_FALSE(ParseAgentName("missions/m/agents/-", false).ok());
  EXPECT_FALSE(ParseLocalMapName("missions/m/localMaps/-", true)->local_map.IsValid());
  EXPECT_FALSE(ParseLocalMapName("missions/m/localMaps/-", false).ok());
}

TEST(ResourceNamesTest, OthersAreRefusedWithTheFormThatIsWanted) {
  for (const char* name : {"", "m", "missions/", "missions/m/", "missions/a b", "mission/m",
                           "missions/-", "missions/../x"}) {
    const absl::Status status = ParseMissionName(name).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << name;
  }
  const std::string map = "missions/m/localMaps/";
  for (const std::string& name : {map + "12", map + "0000000000000000", map + "00c0ffee00c0ffeg",
                                  map + "00c0ffee00c0ffee0"}) {
    const absl::Status status = ParseLocalMapName(name, false).status();
    EXPECT_THAT(std::string(status.message()), HasSubstr("16 hexadecimal digits")) << name;
  }
  const std::string keyframes = map + "00c0ffee00c0ffee/keyframes/";
  for (const std::string& name : {keyframes, keyframes + "-1", keyframes + "4294967295",
                                  keyframes + "1x", keyframes + "99999999999"}) {
    EXPECT_FALSE(ParseKeyframeName(name).ok()) << name;
  }
}

TEST(ResourceNamesTest, LastSegmentIsWhatComesAfterTheLastSlash) {
  EXPECT_EQ(LastSegment("missions/lab/agents/alpha"), "alpha");
  EXPECT_EQ(LastSegment("alpha"), "alpha");
  EXPECT_EQ(LastSegment("missions/"), "");
}

TEST(ResourceNamesTest, HostileBytesAreEscapedInTheMessage) {
  const absl::Status status = ParseMissionName("missions/\x01\n\xff").status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("\\x01\\n\\xff"));
}

}  // namespace
}  // namespace corbslam::services
