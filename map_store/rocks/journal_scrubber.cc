#include "map_store/rocks/journal_scrubber.h"

#include <glog/logging.h>

#include <utility>

#include "absl/time/clock.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kScrubStepsLower = 15;
constexpr uint64_t kPieceBytes = 256 << 10;
// Small folders are not read all the time.
constexpr absl::Duration kBetweenScrubs = absl::Minutes(10);

}  // namespace

JournalScrubber::JournalScrubber(ListMissions missions, uint64_t bytes_per_s)
    : missions_(std::move(missions)), bytes_per_s_(bytes_per_s) {
  if (bytes_per_s_ > 0) thread_ = std::thread([this] { Run(); });
}

JournalScrubber::~JournalScrubber() {
  Stop();
  if (thread_.joinable()) thread_.join();
}

void JournalScrubber::Stop() {
  absl::MutexLock lock(&mutex_);
  stopped_ = true;
}

ScrubCounts JournalScrubber::counts() const {
  absl::MutexLock lock(&mutex_);
  return counts_;
}

bool JournalScrubber::Pause(absl::Duration pause) {
  absl::MutexLock lock(&mutex_);
  mutex_.AwaitWithTimeout(absl::Condition(&stopped_), pause);
  return !stopped_;
}

void JournalScrubber::Run() {
  StepBehindRobots(kScrubStepsLower, "looking for damage");
  while (Pause(kBetweenScrubs)) {
    RunRound([this](uint64_t bytes) {
      return Pause(absl::Seconds(static_cast<double>(bytes) / static_cast<double>(bytes_per_s_)));
    });
  }
}

void JournalScrubber::RunRound(const std::function<bool(uint64_t bytes)>& pause) {
  for (const std::shared_ptr<MissionJournal>& mission : missions_()) {
    if (mission->Damage().ok() && !ReadMission(*mission, pause)) return;
  }
  absl::MutexLock lock(&mutex_);
  ++counts_.rounds;
  counts_.round_ended = absl::Now();
}

bool JournalScrubber::ReadMission(const MissionJournal& mission,
                                  const std::function<bool(uint64_t bytes)>& pause) {
  std::string from;
  do {
    const absl::StatusOr<uint64_t> read = mission.Scrub(kPieceBytes, from);
    if (!read.ok()) {
      // Else it was closed meanwhile.
      if (!absl::IsDataLoss(read.status())) return true;
      LOG(ERROR) << "mission " << mission.name() << " is damaged on the disk: " << read.status();
      absl::MutexLock lock(&mutex_);
      ++counts_.damaged;
      return true;
    }
    {
      absl::MutexLock lock(&mutex_);
      counts_.bytes += *read;
    }
    if (!pause(*read)) return false;
  } while (!from.empty());
  return true;
}

}  // namespace corbslam::map_store
