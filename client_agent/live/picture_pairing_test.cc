#include "client_agent/live/picture_pairing.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>
#include <vector>

#include "absl/time/clock.h"

namespace corbslam::client_agent {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr absl::Duration kLong = absl::Seconds(20);

LivePicture At(int64_t time_ms) { return {time_ms * kMs, cv::Mat(2, 2, CV_8UC1)}; }

std::optional<LivePair> TakeNow(PicturePairing& pairing) {
  auto pair = pairing.Take(absl::InfinitePast());
  EXPECT_TRUE(pair.ok()) << pair.status();
  return *std::move(pair);
}

TEST(PicturePairingTest, PairsWhatIsOfOneTime) {
  PicturePairing pairing(true, 5 * kMs);
  pairing.Push(LiveSide::kFirst, At(100));
  EXPECT_FALSE(TakeNow(pairing).has_value());
  pairing.Push(LiveSide::kSecond, At(104));
  const auto pair = TakeNow(pairing);
  ASSERT_TRUE(pair.has_value());
  EXPECT_EQ(pair->first.timestamp_ns, 100 * kMs);
  EXPECT_EQ(pair->second.timestamp_ns, 104 * kMs);
  EXPECT_EQ(pair->number, 0u);
  EXPECT_FALSE(TakeNow(pairing).has_value()) << "it was taken";
}

// The second camera stamps its pictures 40 ms early.
TEST(PicturePairingTest, AddsTheSecondSidesTimeOffset) {
  PicturePairing pairing(true, 5 * kMs, 40 * kMs);
  pairing.Push(LiveSide::kSecond, At(58));
  pairing.Push(LiveSide::kFirst, At(100));
  const auto pair = TakeNow(pairing);
  ASSERT_TRUE(pair.has_value());
  EXPECT_EQ(pair->first.timestamp_ns, 100 * kMs);
  EXPECT_EQ(pair->second.timestamp_ns, 98 * kMs);
  pairing.Push(LiveSide::kFirst, At(200));
  pairing.Push(LiveSide::kSecond, At(164));
  const CameraCounts counts = pairing.counts();
  EXPECT_EQ(counts.frames, 2u);
  EXPECT_EQ(counts.mean_apart_ns, 1 * kMs);
  EXPECT_EQ(counts.most_apart_ns, 4 * kMs);
}

// One side starts earlier and loses a picture; the other side's come later than they are.
TEST(PicturePairingTest, PassesOverPicturesWithoutACounterpart) {
  PicturePairing pairing(true, 5 * kMs);
  for (const int64_t time_ms : {0, 50, 100, 200, 250}) pairing.Push(LiveSide::kFirst, At(time_ms));
  std::vector<int64_t> times;
  for (const int64_t time_ms : {98, 149, 201, 252}) {
    pairing.Push(LiveSide::kSecond, At(time_ms));
    if (const auto pair = TakeNow(pairing); pair.has_value()) {
      times.push_back(pair->first.timestamp_ns / kMs);
      EXPECT_LE(std::abs(pair->first.timestamp_ns - pair->second.timestamp_ns), 5 * kMs);
    }
  }
  EXPECT_EQ(times, (std::vector<int64_t>{100, 200, 250}));
  EXPECT_EQ(pairing.counts().unpaired, 3u);
  EXPECT_EQ(pairing.counts().frames, 3u);
}

TEST(PicturePairingTest, TheNewestWins) {
  PicturePairing pairing(false, 0);
  for (int64_t i = 0; i < 5; ++i) pairing.Push(LiveSide::kFirst, At(i));
  const auto pair = TakeNow(pairing);
  ASSERT_TRUE(pair.has_value());
  EXPECT_EQ(pair->number, 4u);
  EXPECT_EQ(pairing.counts().overtaken, 4u);
}

TEST(PicturePairingTest, TimesThatDoNotGrowAreDropped) {
  PicturePairing pairing(false, 0);
  for (const int64_t time_ms : {10, 20, 20, 15, 30}) pairing.Push(LiveSide::kFirst, At(time_ms));
  EXPECT_EQ(pairing.counts().late, 2u);
  EXPECT_EQ(pairing.counts().frames, 3u);
}

constexpr int64_t kYears_ms = int64_t{1'700'000'000} * 1000;

void PushPair(PicturePairing& pairing, int64_t time_ms) {
  pairing.Push(LiveSide::kFirst, At(time_ms));
  pairing.Push(LiveSide::kSecond, At(time_ms));
}

// One picture's stamp is of another clock, of one side or both.
TEST(PicturePairingTest, AStampOfAnotherClockCostsOneFrame) {
  PicturePairing pairing(true, 5 * kMs);
  PushPair(pairing, 100'000);
  PushPair(pairing, kYears_ms);
  PushPair(pairing, 100'050);
  pairing.Push(LiveSide::kFirst, At(kYears_ms));
  pairing.Push(LiveSide::kSecond, At(100'100));
  PushPair(pairing, 100'150);
  PushPair(pairing, 50);
  PushPair(pairing, 100'200);
  const CameraCounts counts = pairing.counts();
  EXPECT_EQ(counts.frames, 4u);
  EXPECT_EQ(counts.ahead, 3u);
  EXPECT_EQ(counts.late, 2u);
  EXPECT_EQ(TakeNow(pairing)->drive, 0);
}

TEST(PicturePairingTest, TimesOfAnotherClockThatStayBeginADrive) {
  for (const int64_t begin_ms : {int64_t{50}, kYears_ms}) {
    PicturePairing pairing(true, 5 * kMs);
    PushPair(pairing, 100'000);
    EXPECT_EQ(TakeNow(pairing)->drive, 0);
    for (int i = 0; i < 10; ++i) PushPair(pairing, begin_ms + i);
    const auto pair = TakeNow(pairing);
    ASSERT_TRUE(pair.has_value());
    EXPECT_EQ(pair->drive, 1);
    EXPECT_EQ(pair->first.timestamp_ns, (begin_ms + 9) * kMs);
  }
}

// The right camera's clock is set some pictures after the left one's.
TEST(PicturePairingTest, OneSidesClockMayFollowTheOthersLater) {
  PicturePairing pairing(true, 5 * kMs);
  for (int i = 0; i < 3; ++i) PushPair(pairing, 100'000 + 50 * i);
  while (TakeNow(pairing).has_value()) {
  }
  for (int i = 3; i < 40; ++i) {
    pairing.Push(LiveSide::kFirst, At(50 * i));
    pairing.Push(LiveSide::kSecond, At(i < 12 ? 100'000 + 50 * i : 50 * i));
  }
  const auto pair = TakeNow(pairing);
  ASSERT_TRUE(pair.has_value());
  EXPECT_GE(pair->drive, 1);
  EXPECT_EQ(pair->first.timestamp_ns, 50 * 39 * kMs);
  EXPECT_EQ(pair->second.timestamp_ns, pair->first.timestamp_ns);
}

TEST(PicturePairingTest, ASideThatStoppedTakesNoMemory) {
  PicturePairing pairing(true, kMs);
  for (int64_t i = 0; i < 1000; ++i) pairing.Push(LiveSide::kFirst, At(i * 10));
  EXPECT_GE(pairing.counts().unpaired, 990u);
  pairing.Push(LiveSide::kSecond, At(9990));
  EXPECT_TRUE(TakeNow(pairing).has_value()) << "the newest are kept";
}

TEST(PicturePairingTest, GivesTheLastFrameBeforeItsEnd) {
  PicturePairing pairing(false, 0);
  pairing.Push(LiveSide::kFirst, At(1));
  pairing.End(absl::OkStatus());
  EXPECT_TRUE(TakeNow(pairing).has_value());
  EXPECT_TRUE(absl::IsOutOfRange(pairing.Take(absl::InfiniteFuture()).status()));

  PicturePairing failing(false, 0);
  failing.End(absl::UnavailableError("unplugged"));
  failing.End(absl::OkStatus());
  EXPECT_EQ(failing.Take(absl::InfiniteFuture()).status().message(), "unplugged");
}

TEST(PicturePairingTest, WakesWhoeverWaits) {
  PicturePairing pairing(true, kMs);
  std::thread camera([&] {
    pairing.Push(LiveSide::kSecond, At(7));
    pairing.Push(LiveSide::kFirst, At(7));
  });
  const auto pair = pairing.Take(absl::Now() + kLong);
  camera.join();
  ASSERT_TRUE(pair.ok() && pair->has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
