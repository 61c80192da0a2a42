#include "map_store/rocks/journal_tidier.h"

#include <glog/logging.h>

#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "slam/util/named_thread.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kStepsLower = 10;
constexpr absl::Duration kBetweenRounds = absl::Seconds(10);
constexpr absl::Duration kBetweenWarnings = absl::Minutes(10);

}  // namespace

JournalTidier::JournalTidier(ListMissions missions)
    : missions_(std::move(missions)), thread_(StartThread("journal tidier", [this] { Run(); })) {}

JournalTidier::~JournalTidier() {
  Stop();
  thread_.join();
}

void JournalTidier::Wake() {
  absl::MutexLock lock(&mutex_);
  woken_ = true;
}

void JournalTidier::Stop() {
  absl::MutexLock lock(&mutex_);
  stopped_ = true;
}

bool JournalTidier::Wait() {
  absl::MutexLock lock(&mutex_);
  const auto is_due = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return woken_ || stopped_; };
  mutex_.AwaitWithTimeout(absl::Condition(&is_due), kBetweenRounds);
  woken_ = false;
  return !stopped_;
}

void JournalTidier::Run() {
  // Robots wait for the other threads, but nobody waits for this one.
  StepBehindRobots(kStepsLower, "tidying the journal");
  absl::Time next_warning = absl::InfinitePast();
  while (Wait()) {
    for (const std::shared_ptr<MissionJournal>& mission : missions_()) {
      const absl::Status tidied = mission->Tidy(absl::Now());
      if (tidied.ok() || absl::Now() < next_warning) continue;
      LOG(WARNING) << "space does not come back yet: " << tidied;
      next_warning = absl::Now() + kBetweenWarnings;
    }
  }
}

}  // namespace corbslam::map_store
