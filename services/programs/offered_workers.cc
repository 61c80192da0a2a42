#include "services/programs/offered_workers.h"

#include <algorithm>

#include "services/programs/store_address.h"

namespace corbslam::services {

std::set<std::string> OfferedWorkers(const std::vector<map_store::DirectoryStore>& stores,
                                     const std::vector<std::string>& own,
                                     const std::string& machine) {
  std::set<std::string> offered;
  for (const map_store::DirectoryStore& store : stores) {
    if (store.is_own || !store.IsAlive()) continue;
    for (const std::string& worker : store.workers) {
      const bool is_reached = store.machine == machine || !IsReachedFromHereAlone(worker);
      const bool is_own = std::find(own.begin(), own.end(), worker) != own.end();
      if (is_reached && !is_own) offered.insert(worker);
    }
  }
  return offered;
}

}  // namespace corbslam::services
