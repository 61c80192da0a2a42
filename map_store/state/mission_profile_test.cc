#include "map_store/state/mission_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;

MissionProfile MakeProfile() {
  MissionProfile profile;
  profile.description = "the old mine";
  profile.labels = {{"site", "mine-3"}, {"empty", ""}};
  profile.limits = {1000, 1 << 30, 1 << 30, 100'000};
  profile.agent_limits["alpha"] = {.keyframes = 10, .uplink_bytes_per_second = 5000};
  profile.retention_s = 3600;
  profile.origin = GeoOrigin{-33.8, 151.2, 40, 360};
  profile.created_ns = 5;
  profile.last_used_ns = 6;
  return profile;
}

TEST(MissionProfileTest, NamesTheFieldItsValueAndItsBound) {
  EXPECT_TRUE(ValidateProfile(MissionProfile()).ok());
  EXPECT_TRUE(ValidateProfile(MakeProfile()).ok());
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<std::pair<std::string, std::function<void(MissionProfile&)>>> cases = {
      {"description has 1001 bytes, must have at most 1000",
       [](auto& p) { p.description.assign(1001, 'x'); }},
      {"labels has the key \"a b\"", [](auto& p) { p.labels["a b"] = "c"; }},
      {"labels has the key \"\"", [](auto& p) { p.labels[""] = "c"; }},
      {"1 to 63", [](auto& p) { p.labels[std::string(64, 'k')] = "c"; }},
      {"labels[k] has 256 bytes, must have at most 255",
       [](auto& p) { p.labels["k"].assign(256, 'x'); }},
      {"labels has 65 labels, must have at most 64",
       [](auto& p) {
         p.labels.clear();
         for (int i = 0; i < 65; ++i) p.labels[absl::StrCat("k", i)];
       }},
      {"limits.uplink_bytes_per_second is 999, must be 0",
       [](auto& p) { p.limits.uplink_bytes_per_second = 999; }},
      {"agent_limits has 1001 agents, must have at most 1000",
       [](auto& p) {
         p.agent_limits.clear();
         for (int i = 0; i < 1001; ++i) p.agent_limits[absl::StrCat("a", i)];
       }},
      {"agent_limits has the agent \"agents/a\"", [](auto& p) { p.agent_limits["agents/a"]; }},
      {"agent_limits has the agent \".a\"", [](auto& p) { p.agent_limits[".a"]; }},
      {"agent_limits[a].memory_bytes is 5", [](auto& p) { p.agent_limits["a"].memory_bytes = 5; }},
      {"disk_bytes 7, must be 0", [](auto& p) { p.agent_limits["a"].disk_bytes = 7; }},
      {"agent_limits[a].uplink_bytes_per_second is 1",
       [](auto& p) { p.agent_limits["a"].uplink_bytes_per_second = 1; }},
      {"origin.latitude_deg is 90.5, must be -90 to 90",
       [](auto& p) { p.origin->latitude_deg = 90.5; }},
      {"origin.latitude_deg is nan", [](auto& p) { p.origin->latitude_deg = kNan; }},
      {"origin.longitude_deg is -181", [](auto& p) { p.origin->longitude_deg = -181; }},
      {"origin.altitude_m is inf", [](auto& p) { p.origin->altitude_m = kInfinity; }},
      {"origin.heading_deg is -1, must be 0 to 360", [](auto& p) { p.origin->heading_deg = -1; }},
      {"created_ns is -1", [](auto& p) { p.created_ns = -1; }},
      {"last_used_ns is -2", [](auto& p) { p.last_used_ns = -2; }}};
  for (const auto& [says, break_it] : cases) {
    MissionProfile profile = MakeProfile();
    break_it(profile);
    const absl::Status status = ValidateProfile(profile);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << says;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
  }
}

TEST(MissionProfileTest, OnlyNamedFieldsArePutInEachAsAWhole) {
  MissionProfile values;
  values.limits.keyframes = 7;
  MissionProfile profile = MakeProfile();
  PutFields(values, {ProfileField::kLimits, ProfileField::kOrigin}, profile);
  MissionProfile expected = MakeProfile();
  expected.limits = {.keyframes = 7};
  expected.origin.reset();
  EXPECT_EQ(profile, expected);
  PutFields(values,
            {ProfileField::kDescription, ProfileField::kLabels, ProfileField::kAgentLimits,
             ProfileField::kRetention},
            profile);
  // When it was made and used nobody sets.
  values.created_ns = 5;
  values.last_used_ns = 6;
  EXPECT_EQ(profile, values);
}

TEST(MissionProfileTest, AnAgentsOwnUplinkGoesBeforeTheMissions) {
  MissionProfile profile = MakeProfile();
  EXPECT_EQ(UplinkLimit(profile, "alpha"), 5000u);
  EXPECT_EQ(UplinkLimit(profile, "bravo"), 100'000u);
  profile.agent_limits["alpha"].uplink_bytes_per_second = 0;
  EXPECT_EQ(UplinkLimit(profile, "alpha"), 100'000u);
  EXPECT_EQ(UplinkLimit(MissionProfile(), "alpha"), 0u);
}

}  // namespace
}  // namespace corbslam::map_store
