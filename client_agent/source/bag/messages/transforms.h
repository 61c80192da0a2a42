// The fixed frames of a robot, as /tf_static says them.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_TRANSFORMS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_TRANSFORMS_H_

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "client_agent/source/bag/messages/ros_messages.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

class TransformTree {
 public:
  // The last word about a child counts.
  void Add(const RosTransform& transform) {
    parents_.insert_or_assign(transform.child,
                              std::pair(transform.parent, transform.parent_from_child));
  }
  bool empty() const { return parents_.empty(); }
  // Returns x_target = T * x_source; nullopt where no chain of transforms joins the two.
  std::optional<Rigid3d> TargetFromSource(const std::string& target,
                                          const std::string& source) const;

 private:
  // Returns each frame that `frame` stands in, with frame's pose in it.
  std::map<std::string, Rigid3d> Ancestors(const std::string& frame) const;

  std::map<std::string, std::pair<std::string, Rigid3d>> parents_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_TRANSFORMS_H_
