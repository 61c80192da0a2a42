#include "map_store/rocks/journal_scrubber.h"

#include <glog/logging.h>

#include <utility>

#include "absl/time/clock.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kScrubStepsLower = 15;
constexpr uint64_t kPieceBytes = 256 << 10;
// Small folders are not read all the time.
constexpr absl::Duration kBetweenScrubs = absl::Minutes(10);

}  // namespace

JournalScrubber::JournalScrubber(Access access, uint64_t bytes_per_s)
    : access_(std::move(access)), bytes_per_s_(bytes_per_s) {
  if (bytes_per_s_ > 0) thread_ = StartThread("scrubber", [this] { Run(); });
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

void JournalScrubber::RunRound(const ReadPace& pause) {
  bool stopped = false;
  const ReadPace counted = [&](uint64_t bytes) {
    {
      absl::MutexLock lock(&mutex_);
      counts_.bytes += bytes;
    }
    stopped = stopped || !pause(bytes);
    return !stopped;
  };
  for (const MissionPtr& mission : access_.list_open()) {
    if (!mission->Damage().ok()) continue;
    const absl::Status read = ReadMission(*mission, counted);
    if (stopped) return;
    if (absl::IsDataLoss(read)) Count(mission->name(), read);
  }
  for (const std::string& name : access_.list_closed()) {
    const absl::Status read = ReadClosed(name, counted);
    if (stopped) return;
    if (absl::IsDataLoss(read) && access_.note_closed(name, read)) Count(name, read);
  }
  absl::MutexLock lock(&mutex_);
  ++counts_.rounds;
  counts_.round_ended = absl::Now();
}

void JournalScrubber::Count(const std::string& name, const absl::Status& damage) {
  LOG(ERROR) << "mission " << name << " is damaged on the disk: " << damage;
  absl::MutexLock lock(&mutex_);
  ++counts_.damaged;
}

absl::Status JournalScrubber::ReadMission(const MissionJournal& mission, const ReadPace& pause) {
  RETURN_IF_ERROR(mission.ScrubLogs(pause));
  std::string from;
  do {
    ASSIGN_OR_RETURN(const uint64_t read, mission.Scrub(kPieceBytes, from));
    if (!pause(read)) return absl::CancelledError();
  } while (!from.empty());
  return absl::OkStatus();
}

absl::Status JournalScrubber::ReadClosed(const std::string& name, const ReadPace& pause) {
  const ReadPace goes_on = [&](uint64_t bytes) { return pause(bytes) && access_.is_closed(name); };
  ASSIGN_OR_RETURN(const MissionPtr mission, access_.open_closed(name, goes_on));
  return mission == nullptr ? absl::OkStatus() : ReadMission(*mission, goes_on);
}

}  // namespace corbslam::map_store
