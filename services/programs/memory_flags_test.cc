#include "services/programs/memory_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "services/convert/robot_settings_check.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr uint64_t kMiB = uint64_t{1} << 20;

// Of a stereo camera of 752x480.
MemoryNeeds Needs(uint64_t outbox_bytes = 64 * kMiB) {
  return {.features = 2000, .width_px = 752, .height_px = 480, .outbox_bytes = outbox_bytes};
}

struct Parsed {
  MemoryFlags memory;
  ShareFlags share;
  std::string error;  // Empty: the arguments are good.

  absl::Status Check(bool has_server = true) const {
    return CheckMemoryFlags(memory, share, Needs(), has_server);
  }
};

Parsed Parse(const std::vector<std::string>& arguments) {
  Parsed parsed;
  CLI::App app;
  AddMemoryFlags(app, parsed.memory);
  AddShareFlags(app, parsed.share);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Error& error) {
    parsed.error = error.what();
  }
  return parsed;
}

TEST(MemoryFlagsTest, WithoutItThereIsNoBound) {
  const Parsed parsed = Parse({});
  EXPECT_EQ(parsed.memory.budget_bytes, 0u);
  EXPECT_EQ(MaxMapBytes(parsed.memory, Needs()), 0u);
  EXPECT_TRUE(parsed.Check(/*has_server=*/false).ok());
}

TEST(MemoryFlagsTest, AreBytesWithAUnit) {
  EXPECT_EQ(Parse({"--memory-budget", "500MB"}).memory.budget_bytes, 500 * kMiB);
  EXPECT_EQ(Parse({"--memory-budget=1GiB"}).memory.budget_bytes, 1024 * kMiB);
  EXPECT_EQ(Parse({"--memory-budget", "0.5GB"}).memory.budget_bytes, 512 * kMiB);
  EXPECT_THAT(Parse({"--memory-budget", "much"}).error,
              HasSubstr("is \"much\", must be a number of bytes, as 500MB or 0.5GB"));
  EXPECT_NE(Parse({"--memory-budget", "-5MB"}).error, "");
}

TEST(MemoryFlagsTest, TheMapHasWhatTheRestLeaves) {
  const Parsed parsed = Parse({"--memory-budget", "500MB"});
  EXPECT_TRUE(parsed.Check().ok()) << parsed.Check();
  const uint64_t map = MaxMapBytes(parsed.memory, Needs());
  EXPECT_GT(map, 120 * kMiB);
  EXPECT_LE(2 * map + RobotItselfBytes(Needs()) + 64 * kMiB, 500 * kMiB)
      << "an adjustment takes as much";
  EXPECT_LT(MaxMapBytes(parsed.memory, Needs(), /*has_server=*/false), map)
      << "what comes back is read by the robot itself";
  EXPECT_GT(MaxMapBytes(parsed.memory, Needs(0)), map)
      << "what the outbox does not take is the map's";
}

TEST(MemoryFlagsTest, TooLittleIsRefusedWithValueAndLimit) {
  const uint64_t least = RobotItselfBytes(Needs()) + 64 * kMiB + LeastBytesForMap(Needs());
  EXPECT_THAT(Parse({"--memory-budget", "500"}).Check().message(),
              AllOf(HasSubstr("--memory-budget is 500 bytes"),
                    HasSubstr(std::to_string((least + kMiB - 1) >> 20) + " MiB"),
                    HasSubstr("with a unit"), HasSubstr("pictures of 752x480")));
  Parsed parsed;
  parsed.memory.budget_bytes = least;
  EXPECT_TRUE(parsed.Check().ok());
  EXPECT_GE(MaxMapBytes(parsed.memory, Needs()), 8 * kMiB);
  --parsed.memory.budget_bytes;
  EXPECT_TRUE(absl::IsInvalidArgument(parsed.Check()));
}

TEST(MemoryFlagsTest, TheFloorIsOfTheRobotsOwnPicturesAndFeatures) {
  const auto floor_of = [](const MemoryNeeds& needs) {
    return RobotItselfBytes(needs) + LeastBytesForMap(needs);
  };
  const MemoryNeeds small = {.features = 500, .width_px = 320, .height_px = 240};
  const MemoryNeeds large = {.features = 4000, .width_px = 1920, .height_px = 1200};
  EXPECT_LT(floor_of(small) + 20 * kMiB, floor_of(Needs()));
  EXPECT_LT(floor_of(Needs()) + 80 * kMiB, floor_of(large));
  // What is set from afar is refused before anybody knows the robot, if no robot can follow.
  const MemoryNeeds smallest = {.features = 50, .width_px = 64, .height_px = 64};
  EXPECT_GE(kLeastMemoryBudget_bytes, floor_of(smallest));
  EXPECT_LE(kLeastMemoryBudget_bytes, floor_of(small) + 32 * kMiB);
}

TEST(MemoryFlagsTest, ASmallBudgetHasASmallOutbox) {
  EXPECT_EQ(OutboxBytesOf(MemoryFlags()), 64 * kMiB);
  EXPECT_EQ(OutboxBytesOf({.budget_bytes = 160 * kMiB}), 20 * kMiB);
  EXPECT_EQ(OutboxBytesOf({.budget_bytes = 4096 * kMiB}), 64 * kMiB);
}

// As when an outbox was made before the budget was set from afar.
TEST(MemoryFlagsTest, ABudgetThatIsUsedUpIsNoBoundlessMap) {
  const MemoryNeeds needs = Needs(500 * kMiB);
  EXPECT_EQ(MaxMapBytes({.budget_bytes = 300 * kMiB}, needs), LeastBytesForMap(needs) / 2);
}

TEST(MemoryFlagsTest, ANegativeOneIsNotBoundless) {
  EXPECT_THAT(Parse({"--memory-budget=-1"}).error,
              HasSubstr("is \"-1\", must be a number of bytes, as 500MB or 0.5GB"));
}

TEST(MemoryFlagsTest, NeedsAStore) {
  EXPECT_THAT(Parse({"--memory-budget", "500MB"}).Check(/*has_server=*/false).message(),
              HasSubstr("--memory-budget needs --server"));
}

TEST(MemoryFlagsTest, OthersMapsAreBoundedToo) {
  Parsed parsed = Parse({"--memory-budget", "500MB", "--share", "everything"});
  EXPECT_THAT(parsed.Check().message(),
              AllOf(HasSubstr("--share everything"), HasSubstr("--share nearby")));
  for (const char* mode : {"nearby", "corrections", "none"}) {
    EXPECT_TRUE(Parse({"--memory-budget", "500MB", "--share", mode}).Check().ok()) << mode;
  }
  parsed = Parse({"--memory-budget", "500MB", "--share-radius", "30"});
  EXPECT_TRUE(parsed.Check().ok());
  const ShareFlags bounded = WithBoundedMemory(parsed.share);
  EXPECT_TRUE(CheckShareFlags(bounded, /*has_server=*/true).ok());
  EXPECT_EQ(ScopeOf(bounded), (ShareScope{ShareMode::kNearby, 30}));
  const Parsed none = Parse({"--share", "none"});
  EXPECT_EQ(ScopeOf(WithBoundedMemory(none.share)).mode, ShareMode::kNone);
}

}  // namespace
}  // namespace corbslam::services
