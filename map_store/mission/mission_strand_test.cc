#include "map_store/mission/mission_strand.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "absl/time/clock.h"
#include "map_store/mission/pausing_read.h"

namespace corbslam::map_store {
namespace {

MissionEnvironment MakeEnvironment() {
  static const MapStoreOptions options;
  MissionEnvironment environment;
  environment.options = &options;
  return environment;
}

TEST(MissionStrandTest, AWriterWaitsForAPieceOfAReadAndNotForItsEnd) {
  constexpr int kWrites = 20;
  constexpr int kPieces = 2000;
  MissionStrand strand("m", MakeEnvironment());
  std::atomic<bool> begun = false;
  std::atomic<bool> written = false;
  std::atomic<int> pieces = 0;
  std::thread reader([&] {
    absl::ReaderMutexLock lock(&strand.mutex());
    PausingRead read(strand, [] { return absl::OkStatus(); });
    while (!written && pieces < kPieces) {
      begun = true;
      absl::SleepFor(absl::Milliseconds(1));
      ++pieces;
      read.Pause().IgnoreError();
    }
  });
  while (!begun) std::this_thread::yield();
  for (int i = 0; i < kWrites; ++i) StateWriteLock lock(strand);
  written = true;
  reader.join();
  // Each write waits for one piece, and for a few where the machine is busy; a starved writer waits
  // for all.
  EXPECT_LT(pieces, kPieces / 2);
}

}  // namespace
}  // namespace corbslam::map_store
