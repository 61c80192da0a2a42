#include "map_store/fleet/lease_rules.h"

namespace corbslam::map_store {
namespace {

bool TakesMissions(const DirectoryStore& store) { return store.IsAlive() && !store.is_cordoned; }

// Returns where a mission goes that is to be at the store `wanted`, or anywhere else; null: it
// stays.
const DirectoryStore* ChooseStore(const std::string& own, bool drains, const std::string& wanted,
                                  std::vector<DirectoryStore>& stores) {
  for (const DirectoryStore& store : stores) {
    if (store.name == wanted && wanted != own && TakesMissions(store)) return &store;
  }
  const DirectoryStore* freest = drains ? FindFreest(stores) : nullptr;
  if (freest == nullptr) return nullptr;
  // The next one is another store's turn.
  for (DirectoryStore& store : stores) store.missions += store.name == freest->name;
  return freest;
}

}  // namespace

const DirectoryStore* FindFreest(const std::vector<DirectoryStore>& stores) {
  const DirectoryStore* freest = nullptr;
  for (const DirectoryStore& store : stores) {
    if (store.is_own || !TakesMissions(store)) continue;
    if (freest == nullptr || store.missions < freest->missions) freest = &store;
  }
  return freest;
}

const DirectoryStore* FindTaker(StoreDuty own_duty, const std::string& wanted,
                                const std::vector<DirectoryStore>& stores) {
  if (own_duty != StoreDuty::kTakesMissions) {
    if (const DirectoryStore* substitute = FindFreest(stores)) return substitute;
  }
  if (wanted.empty()) return nullptr;
  for (const DirectoryStore& store : stores) {
    if (store.name == wanted) return !store.is_own && TakesMissions(store) ? &store : nullptr;
  }
  return nullptr;
}

std::map<std::string, DirectoryStore> PlanMoves(const std::string& own, StoreDuty own_duty,
                                                const std::map<std::string, std::string>& held,
                                                std::vector<DirectoryStore> stores) {
  const bool drains = own_duty == StoreDuty::kDrained;
  std::map<std::string, DirectoryStore> moves;
  for (const auto& [mission, wanted] : held) {
    if (const DirectoryStore* to = ChooseStore(own, drains, wanted, stores)) moves[mission] = *to;
  }
  return moves;
}

}  // namespace corbslam::map_store
