#include "map_store/mission/mission_strand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

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

constexpr absl::Duration kPiece = absl::Milliseconds(1);

// Reads in short pieces until it is told to end.
class EndlessReader {
 public:
  explicit EndlessReader(MissionStrand& strand) : thread_([this, &strand] { Run(strand); }) {}
  ~EndlessReader() {
    ends_ = true;
    thread_.join();
  }

  int pieces() const { return pieces_; }
  void WaitForNextPiece() const {
    for (const int before = pieces_; pieces_ == before;) std::this_thread::yield();
  }

 private:
  void Run(MissionStrand& strand) {
    absl::ReaderMutexLock lock(&strand.mutex());
    PausingRead read(strand, [] { return absl::OkStatus(); });
    while (!ends_) {
      absl::SleepFor(kPiece);
      ++pieces_;
      read.Pause().IgnoreError();
    }
  }

  std::atomic<bool> ends_ = false;
  std::atomic<int> pieces_ = 0;
  std::thread thread_;
};

TEST(MissionStrandTest, AWriterWaitsForOnePieceOfALongRead) {
  MissionStrand strand("m", MakeEnvironment());
  EndlessReader reader(strand);
  std::vector<int> waited;
  for (int i = 0; i < 25; ++i) {
    reader.WaitForNextPiece();
    absl::SleepFor(kPiece / 3);
    const int before = reader.pieces();
    StateWriteLock lock(strand);
    waited.push_back(reader.pieces() - before);
  }
  // A single write may come late where the machine is busy. Without the gate most wait for two
  // pieces or three, and some for ten and more.
  std::sort(waited.begin(), waited.end());
  EXPECT_LE(waited[waited.size() / 2], 1) << ::testing::PrintToString(waited);
}

}  // namespace
}  // namespace corbslam::map_store
