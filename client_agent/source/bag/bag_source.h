// Makes bags a kind of source: "bag:FILE" and "bag:DIR".
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_SOURCE_H_

#include "client_agent/source/bag/bag_options.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {

// Registers the kind (source_kinds.h). Thread-safe; once is enough.
void RegisterBagSource();

// Returns the bag that a source names, or null: it is of another kind.
const BagOptions* FindBag(const SourceSpec& source);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_SOURCE_H_
