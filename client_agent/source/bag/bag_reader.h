// Plays a bag.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_READER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_READER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/bag_contents.h"
#include "client_agent/source/bag/bag_options.h"
#include "client_agent/source/frame_reader.h"

namespace corbslam::client_agent {

// Chooses the topics, makes the rig and lists the frames of a bag that was read through. Errors
// name bag, topic and field, and say what to give.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenBagContents(
    std::shared_ptr<const BagContents> contents, const BagOptions& options);

// Reads through the bag first. Pictures are read when they are played: of the bag itself no more
// is in memory than a few chunks.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenBag(const BagOptions& options);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_READER_H_
