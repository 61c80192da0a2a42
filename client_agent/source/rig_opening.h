// Takes a recording's calibration from a rig file.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_OPENING_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_OPENING_H_

#include "absl/status/statusor.h"
#include "client_agent/source/listed_reader.h"
#include "client_agent/source/rig/rig.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {

// Puts the calibration of ?rig=FILE, and where it is from, into `sequence`, whose frames are
// listed. INVALID_ARGUMENT names the rig's file: one of another kind than the recording's layout,
// or of pictures of another size than the first that can be read; and what is improbable without
// ?trust-calibration.
// A robot's recording takes no time offset and no depth.camera but its own rig's: both were applied
// before it was written. A time offset of its cameras is noted where the layout pairs pictures by
// something else.
// Where one camera is played alone (PlaysOneCamera) any rig will do, and its first camera is taken.
absl::Status TakeRig(const SourceSpec& spec, RigKind kind, ListedSequence& sequence);

// Returns whether the first camera of a recording is played alone: by ?cameras=1, or because the
// rig is of one. Errors as TakeRig's.
absl::StatusOr<bool> PlaysOneCamera(const SourceSpec& spec);
// Leaves out the second camera of a sequence whose frames and calibration are there.
void LeaveOutSecond(ListedSequence& sequence);

// Returns by how much the second pictures of frames are stamped too early, as ?rig=FILE says it; 0
// without a rig. Errors as TakeRig's.
absl::StatusOr<int64_t> SecondTimeOffsetOf_ns(const SourceSpec& spec);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_OPENING_H_
