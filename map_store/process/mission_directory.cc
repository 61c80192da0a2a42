#include "map_store/process/mission_directory.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/view/asleep_error.h"
#include "map_store/view/damage_text.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status NoSuchMission(absl::string_view name) {
  return absl::NotFoundError(absl::StrCat("there is no mission ", name));
}

}  // namespace

void EvictedMission::NoteEvicted(uint64_t disk_bytes) {
  summary.info.asleep = true;
  summary.info.disk_bytes = summary.load.disk_bytes = disk_bytes;
  summary.load.memory_bytes = 0;
  summary.load.connected_agents = summary.info.connected_agents = 0;
}

absl::StatusOr<MissionDirectory::EntryPtr> MissionDirectory::Find(absl::string_view name) const {
  const auto it = entries_.find(std::string_view(name.data(), name.size()));
  if (it == entries_.end() || it->second->stage == Stage::kBeingMade) {
    return NoSuchMission(name);
  }
  return it->second;
}

MissionDirectory::EntryPtr& MissionDirectory::Insert(const std::string& name) {
  EntryPtr& entry = entries_[name];
  entry = std::make_shared<Entry>();
  entry->last_used = clock_();
  return entry;
}

void MissionDirectory::Erase(const EntryPtr& entry) {
  entry->gone = true;
  std::erase_if(entries_, [&entry](const auto& named) { return named.second == entry; });
}

absl::Status MissionDirectory::CheckUsable(absl::string_view name, const Entry& entry) {
  if (!entry.gone && !entry.closed_because.empty()) {
    return absl::UnavailableError(
        absl::StrCat("mission ", name, " is being deleted, as ", entry.closed_because));
  }
  if (entry.gone || (entry.being_deleted && entry.mission == nullptr)) {
    return absl::NotFoundError(absl::StrCat("mission ", name, " is deleted"));
  }
  if (entry.stage == Stage::kUnreadable) {
    return absl::DataLossError(SayDamage(name, entry.damage));
  }
  return absl::OkStatus();
}

absl::Status MissionDirectory::Await(absl::string_view name, Entry& entry) {
  const bool others_wake_it = entry.stage == Stage::kLoading;
  const auto has_arrived = [&entry] {
    return entry.gone || (entry.stage != Stage::kLoading && entry.stage != Stage::kBeingEvicted);
  };
  mutex_.Await(absl::Condition(&has_arrived));
  if (others_wake_it && entry.gone) RETURN_IF_ERROR(entry.wake_error);
  RETURN_IF_ERROR(CheckUsable(name, entry));
  if (entry.stage != Stage::kEvicted) return absl::OkStatus();
  // One attempt serves all who came meanwhile.
  if (others_wake_it) RETURN_IF_ERROR(entry.wake_error);
  entry.stage = Stage::kLoading;
  return absl::OkStatus();
}

absl::StatusOr<MissionDirectory::Lease> MissionDirectory::Wake(const std::string& name,
                                                               const EntryPtr& entry) {
  std::shared_ptr<const EvictedMission> evicted;
  {
    absl::MutexLock lock(&mutex_);
    evicted = entry->evicted;
  }
  absl::StatusOr<std::shared_ptr<Mission>> loaded = load_(name, *evicted);
  absl::MutexLock lock(&mutex_);
  entry->wake_error = loaded.status();
  if (loaded.ok()) {
    entry->mission = *std::move(loaded);
    entry->stage = Stage::kLoaded;
    entry->evicted.reset();
    return LeaseOf(entry);
  }
  const bool is_damaged = absl::IsDataLoss(loaded.status());
  entry->stage = is_damaged ? Stage::kUnreadable : Stage::kEvicted;
  if (!is_damaged && asleep_ == Asleep::kForgotten) Erase(entry);
  if (!is_damaged) return loaded.status();
  entry->damage = loaded.status();
  entry->evicted.reset();
  return CheckUsable(name, *entry);
}

absl::StatusOr<MissionDirectory::Lease> MissionDirectory::Use(absl::string_view name) {
  EntryPtr entry;
  {
    absl::MutexLock lock(&mutex_);
    ASSIGN_OR_RETURN(entry, Find(name));
    RETURN_IF_ERROR(Await(name, *entry));
    if (entry->stage == Stage::kLoaded) return LeaseOf(entry);
  }
  return Wake(std::string(name), entry);
}

absl::StatusOr<MissionDirectory::Lease> MissionDirectory::UseOrMake(absl::string_view name,
                                                                    Make make) {
  {
    absl::MutexLock lock(&mutex_);
    const auto it = entries_.find(std::string_view(name.data(), name.size()));
    if (it == entries_.end()) {
      ASSIGN_OR_RETURN(std::shared_ptr<Mission> mission, make(CountLocked()));
      const EntryPtr made = Insert(std::string(name));
      made->mission = std::move(mission);
      made->may_be_vacant = true;
      return LeaseOf(made);
    }
    if (it->second->stage == Stage::kBeingMade) {
      return absl::UnavailableError(absl::StrCat("mission ", name, " is being made"));
    }
    RETURN_IF_ERROR(CheckUsable(name, *it->second));
    // One that nothing was written of must not go before this user has it.
    if (it->second->stage == Stage::kLoaded) return LeaseOf(it->second);
  }
  return Use(name);
}

MissionDirectory::Lease MissionDirectory::UseIfLoaded(absl::string_view name) {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> entry = Find(name);
  return entry.ok() && (*entry)->stage == Stage::kLoaded ? LeaseOf(*entry) : nullptr;
}

absl::StatusOr<MissionDirectory::Lease> MissionDirectory::UseLoaded(absl::string_view name) {
  absl::MutexLock lock(&mutex_);
  ASSIGN_OR_RETURN(const EntryPtr entry, Find(name));
  RETURN_IF_ERROR(CheckUsable(name, *entry));
  if (entry->stage == Stage::kLoaded) return LeaseOf(entry);
  return AsleepError(name);
}

MissionDirectory::Lease MissionDirectory::LeaseOf(const EntryPtr& entry) {
  ++entry->users;
  entry->last_used = clock_();
  // The mission itself is let go last, without the lock.
  return {entry->mission.get(),
          [this, entry, mission = entry->mission](Mission*) { Release(entry); }};
}

void MissionDirectory::Release(const EntryPtr& entry) {
  absl::MutexLock lock(&mutex_);
  --entry->users;
  entry->last_used = clock_();
  const bool may_go = entry->users == 0 && entry->may_be_vacant && !entry->gone &&
                      entry->stage == Stage::kLoaded && !entry->being_deleted;
  if (may_go && entry->mission->IsVacant()) Erase(entry);
}

KnownMission MissionDirectory::Describe(const std::string& name, const Entry& entry) {
  return {name, entry.mission, entry.evicted, entry.damage, entry.last_used, entry.users > 0};
}

absl::StatusOr<KnownMission> MissionDirectory::Peek(absl::string_view name) const {
  absl::MutexLock lock(&mutex_);
  ASSIGN_OR_RETURN(const EntryPtr entry, Find(name));
  return Describe(std::string(name), *entry);
}

std::vector<KnownMission> MissionDirectory::List(absl::string_view after, size_t count) const {
  std::vector<KnownMission> known;
  absl::MutexLock lock(&mutex_);
  auto it = entries_.upper_bound(std::string_view(after.data(), after.size()));
  for (; it != entries_.end() && known.size() < count; ++it) {
    if (it->second->stage == Stage::kBeingMade) continue;
    known.push_back(Describe(it->first, *it->second));
  }
  return known;
}

std::vector<std::weak_ptr<Mission>> MissionDirectory::ListLoaded() const {
  std::vector<std::weak_ptr<Mission>> missions;
  absl::MutexLock lock(&mutex_);
  for (const auto& [name, entry] : entries_) {
    if (entry->stage == Stage::kLoaded) missions.push_back(entry->mission);
  }
  return missions;
}

MissionDirectory::Counts MissionDirectory::CountLocked() const {
  Counts counts;
  for (const auto& [name, entry] : entries_) {
    ++(entry->stage == Stage::kEvicted ? counts.asleep : counts.in_memory);
  }
  return counts;
}

MissionDirectory::Counts MissionDirectory::Count() const {
  absl::MutexLock lock(&mutex_);
  return CountLocked();
}

void MissionDirectory::Add(const std::string& name, std::shared_ptr<Mission> mission) {
  absl::MutexLock lock(&mutex_);
  Insert(name)->mission = std::move(mission);
}

void MissionDirectory::AddEvicted(const std::string& name, EvictedMission evicted) {
  absl::MutexLock lock(&mutex_);
  if (entries_.count(name) > 0) return;
  const EntryPtr& entry = Insert(name);
  entry->stage = Stage::kEvicted;
  entry->last_used = absl::FromUnixNanos(evicted.summary.info.profile.last_used_ns);
  entry->evicted = std::make_shared<const EvictedMission>(std::move(evicted));
}

void MissionDirectory::Remove(const std::string& name, const Mission* mission) {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> entry = Find(name);
  if (!entry.ok() || (*entry)->mission.get() != mission) return;
  // One that wakes is its first user's to remove.
  if ((*entry)->stage != Stage::kLoading) Erase(*entry);
}

void MissionDirectory::AddUnreadable(const std::string& name, absl::Status damage) {
  absl::MutexLock lock(&mutex_);
  const EntryPtr& entry = Insert(name);
  entry->stage = Stage::kUnreadable;
  entry->damage = std::move(damage);
}

absl::Status MissionDirectory::Reserve(const std::string& name,
                                       absl::FunctionRef<absl::Status(const Counts&)> check_room) {
  absl::MutexLock lock(&mutex_);
  const auto it = entries_.find(name);
  if (it != entries_.end()) {
    RETURN_IF_ERROR(CheckUsable(name, *it->second));
    return absl::AlreadyExistsError(absl::StrCat("there is a mission ", name, " already"));
  }
  RETURN_IF_ERROR(check_room(CountLocked()));
  Insert(name)->stage = Stage::kBeingMade;
  return absl::OkStatus();
}

void MissionDirectory::EndMaking(const std::string& name, std::shared_ptr<Mission> mission) {
  absl::MutexLock lock(&mutex_);
  if (mission == nullptr) {
    entries_.erase(name);
  } else {
    Insert(name)->mission = std::move(mission);
  }
}

absl::StatusOr<MissionDirectory::Life> MissionDirectory::FindLife(absl::string_view name) const {
  absl::MutexLock lock(&mutex_);
  ASSIGN_OR_RETURN(const EntryPtr entry, Find(name));
  return Life(entry);
}

absl::StatusOr<std::shared_ptr<Mission>> MissionDirectory::BeginDeletion(
    absl::string_view name, const Life& life, std::string closed_because) {
  absl::MutexLock lock(&mutex_);
  ASSIGN_OR_RETURN(const EntryPtr entry, Find(name));
  if (life.lock() != entry) {
    return absl::NotFoundError(absl::StrCat("mission ", name, " is deleted"));
  }
  const auto has_arrived = [&entry] {
    return entry->gone || (entry->stage != Stage::kLoading && entry->stage != Stage::kBeingEvicted);
  };
  mutex_.Await(absl::Condition(&has_arrived));
  if (entry->gone) return NoSuchMission(name);
  entry->being_deleted = true;
  entry->closed_because = std::move(closed_because);
  return entry->mission;
}

absl::Status MissionDirectory::CheckEntered(absl::string_view name, const Mission& mission) const {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> entry = Find(name);
  if (!entry.ok() || (*entry)->mission.get() != &mission) {
    return absl::UnavailableError(absl::StrCat("mission ", name, " was deleted meanwhile"));
  }
  return CheckUsable(name, **entry);
}

std::optional<KnownMission> MissionDirectory::BeginExpiry(
    absl::string_view name, absl::FunctionRef<bool(const KnownMission&)> is_due) {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> found = Find(name);
  if (!found.ok()) return std::nullopt;
  Entry& entry = **found;
  const bool may_go = (entry.stage == Stage::kLoaded || entry.stage == Stage::kEvicted) &&
                      entry.users == 0 && !entry.being_deleted;
  KnownMission known = Describe(std::string(name), entry);
  if (!may_go || !is_due(known)) return std::nullopt;
  entry.being_deleted = true;
  entry.closed_because = "its retention has passed";
  return known;
}

void MissionDirectory::EndDeletion(absl::string_view name, bool deleted) {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> entry = Find(name);
  if (!entry.ok()) return;
  (*entry)->being_deleted = false;
  (*entry)->closed_because.clear();
  if (deleted) Erase(*entry);
}

std::vector<MissionDirectory::Unused> MissionDirectory::ListUnused() const {
  std::vector<Unused> unused;
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& [name, entry] : entries_) {
      if (entry->stage != Stage::kLoaded || entry->users > 0 || entry->being_deleted) continue;
      unused.push_back({name, entry->mission, entry->last_used});
    }
  }
  std::ranges::stable_sort(unused, {}, &Unused::last_used);
  return unused;
}

bool MissionDirectory::IsUnused(const Unused& unused) const {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> entry = Find(unused.name);
  return entry.ok() && MayRest(**entry, unused);
}

bool MissionDirectory::MayRest(const Entry& entry, const Unused& unused) {
  return entry.stage == Stage::kLoaded && entry.mission == unused.mission && entry.users == 0 &&
         entry.last_used == unused.last_used && !entry.being_deleted;
}

bool MissionDirectory::BeginEviction(const Unused& unused) {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> entry = Find(unused.name);
  if (!entry.ok() || !MayRest(**entry, unused)) return false;
  (*entry)->stage = Stage::kBeingEvicted;
  return true;
}

void MissionDirectory::CancelEviction(const Unused& unused) {
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> entry = Find(unused.name);
  if (entry.ok()) (*entry)->stage = Stage::kLoaded;
}

void MissionDirectory::EndEviction(const Unused& unused, EvictedMission evicted) {
  auto kept = std::make_shared<const EvictedMission>(std::move(evicted));
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<EntryPtr> found = Find(unused.name);
  if (!found.ok()) return;
  Entry& entry = **found;
  entry.stage = Stage::kEvicted;
  entry.evicted = std::move(kept);
  entry.mission.reset();
  entry.may_be_vacant = false;
  if (asleep_ == Asleep::kForgotten) Erase(*found);
}

}  // namespace corbslam::map_store
