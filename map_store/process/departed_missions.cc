#include "map_store/process/departed_missions.h"

#include <algorithm>

namespace corbslam::map_store {

void DepartedMissions::Note(MissionIdentity mission, Processes processes) {
  // An agent that says nothing of its process can't be told from another one of its name.
  std::erase_if(processes, [](const auto& process) { return process.second == 0; });
  absl::MutexLock lock(&mutex_);
  processes_ += processes.size();
  departed_.push_back({std::move(mission), std::move(processes)});
  while (processes_ > kMaxProcesses) {
    Processes& oldest = departed_[first_with_processes_++].processes;
    processes_ -= oldest.size();
    oldest.clear();
  }
  while (departed_.size() > kMaxMissions) {
    processes_ -= departed_.front().processes.size();
    departed_.pop_front();
    if (first_with_processes_ > 0) --first_with_processes_;
  }
}

bool DepartedMissions::Has(absl::string_view name, absl::string_view uid) const {
  absl::MutexLock lock(&mutex_);
  return std::ranges::any_of(departed_, [&](const Departed& departed) {
    const MissionIdentity& mission = departed.mission;
    return mission.name == name && (mission.uid == uid || mission.uid.empty());
  });
}

bool DepartedMissions::HasProcess(absl::string_view name, absl::string_view present,
                                  const std::string& agent, uint64_t instance) const {
  if (instance == 0) return false;
  absl::MutexLock lock(&mutex_);
  return std::ranges::any_of(departed_, [&](const Departed& departed) {
    if (departed.mission.name != name) return false;
    if (!present.empty() && departed.mission.uid == present) return false;
    const auto process = departed.processes.find(agent);
    return process != departed.processes.end() && process->second == instance;
  });
}

}  // namespace corbslam::map_store
