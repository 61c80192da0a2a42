#include "services/tool/mission/mission_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/tool/mission/mission_json.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

TEST(MissionSettingsTest, ReadsDurations) {
  EXPECT_EQ(*ParseRetention("30d"), 30u * 86'400);
  EXPECT_EQ(*ParseRetention("12h"), 43'200u);
  EXPECT_EQ(*ParseRetention("90m"), 5'400u);
  EXPECT_EQ(*ParseRetention("45s"), 45u);
  EXPECT_EQ(*ParseRetention("never"), 0u);
  EXPECT_EQ(*ParseRetention("0"), 0u);
  for (const char* wrong : {"", "d", "30", "-1d", "1.5h", "0d", "30 days", "99999999d", "1y"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ParseRetention(wrong).status())) << wrong;
  }
}

TEST(MissionSettingsTest, ReadsOrigins) {
  const auto whole = ParseOrigin("52.5,13.25,34.5,90");
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(whole->latitude_deg(), 52.5);
  EXPECT_EQ(whole->longitude_deg(), 13.25);
  EXPECT_EQ(whole->altitude_m(), 34.5);
  EXPECT_EQ(whole->heading_deg(), 90);
  EXPECT_EQ(ParseOrigin("-1,-2")->heading_deg(), 0);
  for (const char* wrong : {"", "1", "1,2,3,4,5", "north,2", "1,,2", "nan,1", "1;2"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ParseOrigin(wrong).status())) << wrong;
  }
}

TEST(MissionSettingsTest, WhatIsNotGivenStays) {
  v1::Mission now;
  now.set_name("missions/lab");
  now.mutable_limits()->set_keyframes(5);
  now.mutable_limits()->set_disk_bytes(6);
  (*now.mutable_labels())["site"] = "3";
  (*now.mutable_labels())["team"] = "red";
  const auto update = MakeUpdate({.labels = {"site=4", "note=a=b"},
                                  .remove_labels = {"team"},
                                  .max_memory_mb = 2,
                                  .uplink_kbps = 8},
                                 now);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_THAT(update->update_mask().paths(), UnorderedElementsAre("labels", "limits"));
  const v1::Mission& mission = update->mission();
  EXPECT_EQ(mission.name(), "missions/lab");
  EXPECT_EQ(mission.limits().keyframes(), 5u);
  EXPECT_EQ(mission.limits().disk_bytes(), 6u);
  EXPECT_EQ(mission.limits().memory_bytes(), 2u << 20);
  EXPECT_EQ(mission.limits().uplink_bytes_per_second(), 1000u);
  EXPECT_EQ(mission.labels().size(), 2u);
  EXPECT_EQ(mission.labels().at("site"), "4");
  EXPECT_EQ(mission.labels().at("note"), "a=b");
}

TEST(MissionSettingsTest, AnAgentsLimitsAreItsOwn) {
  v1::Mission now;
  now.mutable_limits()->set_keyframes(5);
  const auto update = MakeUpdate({.agent = "alpha", .max_keyframes = 3}, now);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_THAT(update->update_mask().paths(), ElementsAre("agent_limits"));
  EXPECT_EQ(update->mission().limits().keyframes(), 5u);
  EXPECT_EQ(update->mission().agent_limits().at("alpha").keyframes(), 3u);
  // One without any limit is not kept.
  const auto back = MakeUpdate({.agent = "alpha", .max_keyframes = 0}, update->mission());
  EXPECT_TRUE(back->mission().agent_limits().empty());
  EXPECT_TRUE(absl::IsInvalidArgument(MakeUpdate({.agent = "alpha"}, now).status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(MakeUpdate({.agent = "alpha", .max_disk_mb = 1}, now).status()));
}

TEST(MissionSettingsTest, TakesBackAndRefuses) {
  v1::Mission now;
  now.set_description("old");
  now.set_retention_s(60);
  now.mutable_origin()->set_latitude_deg(5);
  const auto update = MakeUpdate({.description = "", .retention = "never", .origin = "none"}, now);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_THAT(update->update_mask().paths(), ElementsAre("description", "retention_s", "origin"));
  EXPECT_TRUE(FormatSettings(update->mission()).empty());
  EXPECT_TRUE(absl::IsInvalidArgument(MakeUpdate({}, now).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(MakeUpdate({.labels = {"alone"}}, now).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(MakeUpdate({.remove_labels = {"gone"}}, now).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(MakeUpdate({.uplink_kbps = 7}, now).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(MakeUpdate({.max_disk_mb = ~uint64_t{0}}, now).status()));
}

TEST(MissionSettingsTest, SaysAllThatIsSet) {
  v1::Mission mission;
  EXPECT_EQ(FormatSettings(mission), "");
  mission.set_description("line\n\x1b[2Jtwo");
  (*mission.mutable_labels())["site"] = "3";
  mission.mutable_limits()->set_keyframes(5);
  mission.mutable_limits()->set_memory_bytes(3 << 20);
  (*mission.mutable_agent_limits())["alpha"].set_uplink_bytes_per_second(1000);
  mission.set_retention_s(86'400);
  mission.mutable_origin()->set_latitude_deg(52.5);
  mission.set_created_ns(1);
  const std::string text = FormatSettings(mission);
  EXPECT_THAT(text,
              AllOf(HasSubstr("Description: line\\n\\033[2Jtwo\n"), HasSubstr("Label: site=3\n"),
                    HasSubstr("Limits: 5 keyframes, 3 MiB of memory\n"),
                    HasSubstr("Limits of alpha: 8 kbit/s a robot\n"),
                    HasSubstr("Retention: deleted once unused for 1 d\n"),
                    HasSubstr("Origin: 52.5, 0, 0.000 m"), HasSubstr("Created: ")));
  const nlohmann::ordered_json json = ToJson(mission);
  EXPECT_EQ(json["labels"]["site"], "3");
  EXPECT_EQ(json["limits"]["keyframes"], 5);
  EXPECT_EQ(json["agent_limits"]["alpha"]["uplink_bytes_per_second"], 1000);
  EXPECT_EQ(json["retention_s"], 86'400);
  EXPECT_EQ(json["origin"]["latitude_deg"], 52.5);
  EXPECT_TRUE(ToJson(v1::Mission())["origin"].is_null());
}

}  // namespace
}  // namespace corbslam::services
