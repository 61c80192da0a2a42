#include "client_agent/memory/held_keyframes.h"

#include <utility>

#include "client_agent/memory/visual_contact.h"

namespace corbslam {
namespace {

bool IsSame(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

}  // namespace

KeyframeId HeldKeyframes::HolderOf(KeyframeId id) const {
  const auto it = contacts_.find(id);
  return it != contacts_.end() && it->second.agrees ? it->second.own : KeyframeId();
}

bool HeldKeyframes::IsAsBefore(const Contact& before, const Contact& now) {
  return before.own == now.own && before.shared == now.shared &&
         IsSame(before.foreign_from_map, now.foreign_from_map) &&
         IsSame(before.own_from_map, now.own_from_map);
}

void HeldKeyframes::Update(const Map& map) {
  std::map<KeyframeId, Contact> contacts;
  for (const auto& [id, foreign] : map.keyframes()) {
    if (id.local_map == own_) continue;
    const KeyframeId own_id = MostSharing(foreign, own_);
    const Keyframe* own = map.FindKeyframe(own_id);
    if (own == nullptr) continue;
    Contact now = {own_id, foreign.covisible.at(own_id), foreign.camera_from_map,
                   own->camera_from_map};
    const auto before = contacts_.find(id);
    now.agrees = before != contacts_.end() && IsAsBefore(before->second, now)
                     ? before->second.agrees
                     : AgreeOnSharedPoints(map, foreign, *own);
    contacts.emplace_hint(contacts.end(), id, std::move(now));
  }
  contacts_ = std::move(contacts);
}

}  // namespace corbslam
