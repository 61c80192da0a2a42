#include "map_store/process/mission_loader.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/named_thread.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

// Its threads step as far back as look-ups do: robots of missions that are awake come first.
constexpr int kLoaderStepsLower = 5;

}  // namespace

void MissionLoader::Start(int threads) {
  {
    absl::MutexLock lock(&mutex_);
    running_ = true;
  }
  for (int i = 0; i < threads; ++i) {
    threads_.push_back(StartThread("mission loader", [this] { Run(); }));
  }
}

void MissionLoader::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    running_ = false;
    queue_.clear();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  std::map<std::string, std::vector<Then>> left;
  {
    absl::MutexLock lock(&mutex_);
    left.swap(waiting_);
    waiting_count_ = 0;
  }
  for (const auto& [mission, waiting] : left) {
    for (const Then& then : waiting) {
      then(absl::UnavailableError(absl::StrCat("mission ", mission, " sleeps on: the store ends")));
    }
  }
}

absl::Status MissionLoader::WhenLoaded(const std::string& mission, Then then) {
  std::shared_ptr<const void> awake = directory_.UseIfLoaded(mission);
  if (awake == nullptr) {
    absl::MutexLock lock(&mutex_);
    if (running_) {
      if (waiting_count_ >= kMaxWaiting) {
        return absl::ResourceExhaustedError(
            absl::StrCat(waiting_count_, " calls wait for missions that were asleep, such as ",
                         mission, "; that is the limit"));
      }
      ++waiting_count_;
      std::vector<Then>& waiting = waiting_[mission];
      if (waiting.empty()) queue_.push_back(mission);
      waiting.push_back(std::move(then));
      return absl::OkStatus();
    }
  }
  if (awake != nullptr) {
    then(std::move(awake));
  } else {
    then(use_(mission));
  }
  return absl::OkStatus();
}

std::vector<MissionLoader::Then> MissionLoader::TakeWaiting(const std::string& mission) {
  absl::MutexLock lock(&mutex_);
  const auto it = waiting_.find(mission);
  if (it == waiting_.end()) return {};
  std::vector<Then> waiting = std::move(it->second);
  waiting_.erase(it);
  waiting_count_ -= waiting.size();
  return waiting;
}

void MissionLoader::Run() {
  StepBehindRobots(kLoaderStepsLower, "missions that wake");
  while (true) {
    std::string mission;
    {
      absl::MutexLock lock(&mutex_);
      const auto is_due = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return !running_ || !queue_.empty();
      };
      mutex_.Await(absl::Condition(&is_due));
      if (!running_) return;
      mission = std::move(queue_.front());
      queue_.pop_front();
    }
    const absl::StatusOr<std::shared_ptr<const void>> awake = use_(mission);
    for (const Then& then : TakeWaiting(mission)) then(awake);
  }
}

}  // namespace corbslam::map_store
