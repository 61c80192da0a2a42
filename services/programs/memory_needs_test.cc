#include "services/programs/memory_needs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "services/programs/settings_flags.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr uint64_t kMebibyte = uint64_t{1} << 20;

// Of a stereo camera of 752x480.
MemoryNeeds Needs(uint64_t outbox_bytes = 64 * kMebibyte) {
  return {.features = 2000, .width_px = 752, .height_px = 480, .outbox_bytes = outbox_bytes};
}

struct Parsed {
  SettableFlags flags;
  std::string error;  // Empty: the arguments are good.

  uint64_t budget() const { return flags.memory_budget_bytes; }
  absl::Status Check(bool has_server = true) const {
    return CheckMemoryBudget(budget(), flags.share, Needs(), has_server);
  }
};

Parsed Parse(const std::vector<std::string>& arguments) {
  Parsed parsed;
  CLI::App app;
  AddSettings(app, RowsOf(parsed.flags));
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Error& error) {
    parsed.error = error.what();
  }
  return parsed;
}

TEST(MemoryNeedsTest, WithoutItThereIsNoBound) {
  const Parsed parsed = Parse({});
  EXPECT_EQ(parsed.flags.memory_budget_bytes, 0u);
  EXPECT_EQ(MaxMapBytes(parsed.budget(), Needs()), 0u);
  EXPECT_TRUE(parsed.Check(/*has_server=*/false).ok());
}

TEST(MemoryNeedsTest, AreBytesWithAUnit) {
  EXPECT_EQ(Parse({"--memory-budget", "500MB"}).budget(), 500 * kMebibyte);
  EXPECT_EQ(Parse({"--memory-budget=1GiB"}).budget(), 1024 * kMebibyte);
  EXPECT_EQ(Parse({"--memory-budget", "0.5GB"}).budget(), 512 * kMebibyte);
  EXPECT_THAT(Parse({"--memory-budget", "much"}).error,
              HasSubstr("is \"much\", must be a number of bytes, as 500MB or 0.5GB"));
  EXPECT_NE(Parse({"--memory-budget", "-5MB"}).error, "");
}

TEST(MemoryNeedsTest, TheMapHasWhatTheRestLeaves) {
  const Parsed parsed = Parse({"--memory-budget", "500MB"});
  EXPECT_TRUE(parsed.Check().ok()) << parsed.Check();
  const uint64_t map = MaxMapBytes(parsed.budget(), Needs());
  EXPECT_GT(map, 120 * kMebibyte);
  EXPECT_LE(2 * map + RobotItselfBytes(Needs()) + 64 * kMebibyte, 500 * kMebibyte)
      << "an adjustment takes as much";
  EXPECT_LT(MaxMapBytes(parsed.budget(), Needs(), /*has_server=*/false), map)
      << "what comes back is read by the robot itself";
  EXPECT_GT(MaxMapBytes(parsed.budget(), Needs(0)), map)
      << "what the outbox does not take is the map's";
}

TEST(MemoryNeedsTest, TooLittleIsRefusedWithValueAndLimit) {
  const uint64_t least = RobotItselfBytes(Needs()) + 64 * kMebibyte + LeastBytesForMap(Needs());
  EXPECT_THAT(Parse({"--memory-budget", "500"}).Check().message(),
              AllOf(HasSubstr("--memory-budget is 500 bytes"),
                    HasSubstr(std::to_string((least + kMebibyte - 1) >> 20) + " MiB"),
                    HasSubstr("with a unit"), HasSubstr("pictures of 752x480")));
  Parsed parsed;
  parsed.flags.memory_budget_bytes = least;
  EXPECT_TRUE(parsed.Check().ok());
  EXPECT_GE(MaxMapBytes(parsed.budget(), Needs()), 8 * kMebibyte);
  --parsed.flags.memory_budget_bytes;
  EXPECT_TRUE(absl::IsInvalidArgument(parsed.Check()));
}

TEST(MemoryNeedsTest, TheFloorIsOfTheRobotsOwnPicturesAndFeatures) {
  const auto floor_of = [](const MemoryNeeds& needs) {
    return RobotItselfBytes(needs) + LeastBytesForMap(needs);
  };
  const MemoryNeeds small = {.features = 500, .width_px = 320, .height_px = 240};
  const MemoryNeeds large = {.features = 4000, .width_px = 1920, .height_px = 1200};
  EXPECT_LT(floor_of(small) + 20 * kMebibyte, floor_of(Needs()));
  EXPECT_LT(floor_of(Needs()) + 80 * kMebibyte, floor_of(large));
  // What is set from afar is refused before anybody knows the robot, if no robot can follow.
  const MemoryNeeds smallest = {.features = 50, .width_px = 64, .height_px = 64};
  EXPECT_GE(kLeastMemoryBudget_bytes, floor_of(smallest));
  EXPECT_LE(kLeastMemoryBudget_bytes, floor_of(small) + 32 * kMebibyte);
}

TEST(MemoryNeedsTest, ASmallBudgetHasASmallOutbox) {
  EXPECT_EQ(OutboxBytesOf(0), 64 * kMebibyte);
  EXPECT_EQ(OutboxBytesOf(160 * kMebibyte), 20 * kMebibyte);
  EXPECT_EQ(OutboxBytesOf(4096 * kMebibyte), 64 * kMebibyte);
}

// As when an outbox was made before the budget was set from afar.
TEST(MemoryNeedsTest, ABudgetThatIsUsedUpIsNoBoundlessMap) {
  const MemoryNeeds needs = Needs(500 * kMebibyte);
  EXPECT_EQ(MaxMapBytes(300 * kMebibyte, needs), LeastBytesForMap(needs) / 2);
}

TEST(MemoryNeedsTest, ANegativeOneIsNotBoundless) {
  EXPECT_THAT(Parse({"--memory-budget=-1"}).error,
              HasSubstr("is \"-1\", must be a number of bytes, as 500MB or 0.5GB"));
}

TEST(MemoryNeedsTest, NeedsAStore) {
  EXPECT_THAT(Parse({"--memory-budget", "500MB"}).Check(/*has_server=*/false).message(),
              HasSubstr("--memory-budget needs --server"));
}

TEST(MemoryNeedsTest, OthersMapsAreBoundedToo) {
  Parsed parsed = Parse({"--memory-budget", "500MB", "--share", "everything"});
  EXPECT_THAT(parsed.Check().message(),
              AllOf(HasSubstr("--share everything"), HasSubstr("--share nearby")));
  for (const char* mode : {"nearby", "corrections", "none"}) {
    EXPECT_TRUE(Parse({"--memory-budget", "500MB", "--share", mode}).Check().ok()) << mode;
  }
  parsed = Parse({"--memory-budget", "500MB", "--share-radius", "30"});
  EXPECT_TRUE(parsed.Check().ok());
  EXPECT_TRUE(CheckShare(parsed.flags, /*is_bounded=*/true, /*has_server=*/true).ok());
  EXPECT_EQ(ScopeOf(parsed.flags, /*is_bounded=*/true), (ShareScope{ShareMode::kNearby, 30}));
  const Parsed none = Parse({"--share", "none"});
  EXPECT_EQ(ScopeOf(none.flags, /*is_bounded=*/true).mode, ShareMode::kNone);
}

}  // namespace
}  // namespace corbslam::services
