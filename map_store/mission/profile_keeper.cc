#include "map_store/mission/profile_keeper.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// What may come at once after a pause: a second's worth, and never so little that a batch of a few
// keyframes would wait.
constexpr uint64_t kLeastBurstBytes = 1 << 20;

absl::Duration BurstOf(uint64_t bytes_per_second) {
  return std::max(absl::Seconds(1), absl::Seconds(static_cast<double>(kLeastBurstBytes) /
                                                  static_cast<double>(bytes_per_second)));
}

}  // namespace

absl::Status ProfileKeeper::Write(const MissionProfile& profile) {
  const ProfileRecord record{profile};
  RETURN_IF_ERROR(strand_.Append(record));
  StateWriteLock lock(strand_);
  map_store::Apply(record, strand_.mutable_state());
  return absl::OkStatus();
}

absl::Status ProfileKeeper::Begin(MissionProfile profile) {
  NoteUse();
  profile.created_ns = profile.last_used_ns = used_ns_;
  RETURN_IF_ERROR(ValidateProfile(profile));
  {
    absl::MutexLock turn(&strand_.turn());
    RETURN_IF_ERROR(Write(profile));
  }
  return strand_.Sync();
}

absl::Status ProfileKeeper::Update(const MissionProfile& values,
                                   const std::vector<ProfileField>& fields,
                                   std::optional<uint64_t> expected_revision) {
  return Change([&](MissionProfile& profile) -> absl::Status {
    if (expected_revision.value_or(profile.revision) != profile.revision) {
      return absl::AbortedError(
          absl::StrCat("mission ", strand_.name(), " has settings_revision ", profile.revision,
                       ", and the change was made of ", *expected_revision,
                       ": somebody has changed it meanwhile; read it again and change that"));
    }
    PutFields(values, fields, profile);
    ++profile.revision;
    return absl::OkStatus();
  });
}

absl::Status ProfileKeeper::SetRobotSettings(const std::string& agent,
                                             const SignedSettings& settings) {
  return Change([&](MissionProfile& profile) { return PutSettings(agent, settings, profile); });
}

std::vector<SignedSettings> ProfileKeeper::NewerSettings(const std::string& agent,
                                                         SettingsVersions& told) const {
  return strand_.WithState([&](const MissionState& state) {
    std::vector<SignedSettings> found;
    const auto take = [&](const std::string& of) -> uint64_t {
      const auto entry = state.profile.robot_settings.find(of);
      if (entry == state.profile.robot_settings.end()) return 0;
      found.push_back(entry->second);
      return entry->second.version;
    };
    const uint64_t of_all = take("");
    const SettingsVersions now{of_all, take(agent)};
    if (std::exchange(told, now) == now) found.clear();
    return found;
  });
}

absl::Status ProfileKeeper::Change(const std::function<absl::Status(MissionProfile&)>& change) {
  NoteUse();
  {
    absl::MutexLock turn(&strand_.turn());
    if (strand_.IsDeleted()) return strand_.SayDeleted();
    MissionProfile profile = Get();
    RETURN_IF_ERROR(change(profile));
    // A mission to which no robot has sent anything yet begins here.
    const bool is_new = strand_.state_in_turn().local_maps.empty() && strand_.appended() == 0;
    if (is_new) profile.created_ns = profile.last_used_ns;
    RETURN_IF_ERROR(ValidateProfile(profile));
    RETURN_IF_ERROR(Write(profile));
  }
  return strand_.Sync();
}

int64_t ProfileKeeper::LastUse(const MissionProfile& recorded) const {
  // Since the process began every use was noted, also by a clock that was set back meanwhile.
  const int64_t used_ns = used_ns_;
  return used_ns > 0 ? used_ns : recorded.last_used_ns;
}

MissionProfile ProfileKeeper::Get() const {
  MissionProfile profile =
      strand_.WithState([](const MissionState& state) { return state.profile; });
  profile.last_used_ns = LastUse(profile);
  return profile;
}

absl::Status ProfileKeeper::KeepUse() {
  const int64_t used_ns = used_ns_;
  if (used_ns == 0) return absl::OkStatus();
  absl::MutexLock turn(&strand_.turn());
  // A mission of which nothing was written is forgotten when nobody is in it.
  if (strand_.IsDeleted() || strand_.appended() == 0) return absl::OkStatus();
  MissionProfile profile = Get();
  const int64_t recorded_ns =
      strand_.WithState([](const MissionState& state) { return state.profile.last_used_ns; });
  // The difference is also due where the clock was set back.
  const absl::Duration since = absl::Nanoseconds(profile.last_used_ns - recorded_ns);
  if (absl::AbsDuration(since) < kBetweenUses) return absl::OkStatus();
  return Write(profile);
}

bool ProfileKeeper::IsOutdated() const {
  const MissionProfile profile = Get();
  if (profile.retention_s == 0 || profile.last_used_ns == 0) return false;
  absl::Duration retention = absl::Seconds(profile.retention_s);
  // What nobody has used since the process began may have been used later than is known.
  if (used_ns_ == 0) retention += kBetweenUses;
  return strand_.environment().clock() - absl::FromUnixNanos(profile.last_used_ns) >= retention;
}

absl::Duration ProfileKeeper::PaceUplink(const std::string& agent, uint64_t bytes) {
  const uint64_t limit = strand_.WithState(
      [&agent](const MissionState& state) { return UplinkLimit(state.profile, agent); });
  const absl::Time now = strand_.environment().clock();
  absl::MutexLock lock(&pacing_);
  if (limit == 0) {
    paces_.erase(agent);
    return absl::ZeroDuration();
  }
  Pace& pace = paces_[agent];
  if (pace.bytes_per_second != limit) pace = {limit, ByteBucket(limit, BurstOf(limit))};
  pace.bucket.Spend(static_cast<int64_t>(bytes), now);
  return pace.bucket.Wait(now);
}

}  // namespace corbslam::map_store
