#include "client_agent/source/bag/messages/transforms.h"

namespace corbslam::client_agent {

std::map<std::string, Rigid3d> TransformTree::Ancestors(const std::string& frame) const {
  std::map<std::string, Rigid3d> ancestors = {{frame, Rigid3d::Identity()}};
  Rigid3d ancestor_from_frame;
  auto step = parents_.find(frame);
  while (step != parents_.end()) {
    const auto& [parent, parent_from_child] = step->second;
    ancestor_from_frame = parent_from_child * ancestor_from_frame;
    if (!ancestors.emplace(parent, ancestor_from_frame).second) break;  // A ring.
    step = parents_.find(parent);
  }
  return ancestors;
}

std::optional<Rigid3d> TransformTree::TargetFromSource(const std::string& target,
                                                       const std::string& source) const {
  const std::map<std::string, Rigid3d> of_source = Ancestors(source);
  for (const auto& [frame, frame_from_target] : Ancestors(target)) {
    const auto common = of_source.find(frame);
    if (common != of_source.end()) return frame_from_target.Inverse() * common->second;
  }
  return std::nullopt;
}

}  // namespace corbslam::client_agent
