// A journal whose directory says what a test tells it: where missions are that the store of the
// journal is asked for.
#ifndef CORBSLAM_MAP_STORE_TESTING_TOLD_DIRECTORY_H_
#define CORBSLAM_MAP_STORE_TESTING_TOLD_DIRECTORY_H_

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/mission_leases.h"
#include "map_store/testing/journal_wrapper.h"
#include "slam/exchange/mission_elsewhere.h"

namespace corbslam::testing {

// Says where missions are. It outlives the journals that have it. Thread-safe.
class ToldDirectory {
 public:
  // From here on the mission is at this address.
  void Place(const std::string& mission, const std::string& address) ABSL_LOCKS_EXCLUDED(mutex_) {
    absl::MutexLock lock(&mutex_);
    places_[mission] = address;
  }
  absl::StatusOr<map_store::DirectoryMission> Look(const std::string& mission) const
      ABSL_LOCKS_EXCLUDED(mutex_) {
    absl::MutexLock lock(&mutex_);
    const auto it = places_.find(mission);
    if (it == places_.end()) return absl::NotFoundError("there is no mission " + mission);
    map_store::DirectoryMission listed;
    listed.name = mission;
    listed.holder = "a store of the test";
    listed.address = it->second;
    listed.lease_left = absl::Seconds(10);
    return listed;
  }

 private:
  mutable absl::Mutex mutex_;
  std::map<std::string, std::string> places_ ABSL_GUARDED_BY(mutex_);
};

class JournalOfToldDirectory : public JournalWrapper, public map_store::MissionLeases {
 public:
  explicit JournalOfToldDirectory(const ToldDirectory* directory)
      : JournalWrapper(std::make_unique<map_store::InMemoryJournal>()), directory_(*directory) {}

  map_store::MissionLeases* leases() override { return this; }

  absl::Status Announce(const map_store::DirectoryStore&) override { return absl::OkStatus(); }
  absl::StatusOr<std::vector<map_store::DirectoryStore>> ListStores() const override {
    return std::vector<map_store::DirectoryStore>();
  }
  absl::StatusOr<map_store::DirectoryMission> Look(absl::string_view mission) const override {
    return directory_.Look(std::string(mission));
  }
  absl::StatusOr<std::vector<map_store::DirectoryMission>> List(absl::string_view,
                                                                size_t) const override {
    return std::vector<map_store::DirectoryMission>();
  }
  void LetGo(absl::string_view) override {}
  // All missions of the store that the directory places elsewhere.
  std::map<std::string, absl::Status> TakeLost() override {
    std::map<std::string, absl::Status> lost;
    absl::MutexLock lock(&mutex_);
    for (const std::string& mission : appended_) {
      const auto listed = directory_.Look(mission);
      if (!listed.ok()) continue;
      lost[mission] =
          WithElsewhere(absl::FailedPreconditionError("it was taken over"), listed->address);
    }
    for (const auto& [mission, why] : lost) std::erase(appended_, mission);
    return lost;
  }
  std::map<std::string, map_store::DirectoryStore> ListMoves() const override { return {}; }
  absl::Status GiveTo(absl::string_view, const std::string&) override { return absl::OkStatus(); }
  absl::StatusOr<map_store::DirectoryStore> FindTaker(
      const map_store::DirectoryMission&) const override {
    return absl::NotFoundError("this store takes missions itself");
  }
  void NoteLoad(const map_store::WeighedStore&) override {}
  map_store::FleetCounts counts() const override { return {}; }
  absl::Status CheckReached() const override { return absl::OkStatus(); }
  absl::Duration lease() const override { return absl::Seconds(10); }

  absl::StatusOr<Position> Append(absl::string_view mission,
                                  const map_store::JournalRecord& record) override {
    {
      absl::MutexLock lock(&mutex_);
      const std::string name(mission);
      if (std::find(appended_.begin(), appended_.end(), name) == appended_.end()) {
        appended_.push_back(name);
      }
    }
    return JournalWrapper::Append(mission, record);
  }

 private:
  const ToldDirectory& directory_;
  absl::Mutex mutex_;
  std::vector<std::string> appended_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_TOLD_DIRECTORY_H_
