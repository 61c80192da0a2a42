// Checks whether left and right pictures are those of one stereo pair, taken at the same time.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_STEREO_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_STEREO_CHECKS_H_

#include <vector>

#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/pair_evidence.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::client_agent {

struct StereoJudgement {
  SourceFindings findings;
  std::vector<JudgedPair> pairs;  // Those that could be judged, in order.
};

// Judges matches between the pictures of pairs, found without knowledge of the geometry: exchanged
// cameras, rows apart or turned against each other, a camera that is late, pictures that have
// nothing to do with each other, a baseline in other units. Frames of another size than the
// calibration's are passed over (CheckPictures names them), and so are those with too few features
// to judge. Pure; any thread.
StereoJudgement JudgeStereoPair(const StereoCalibration& calibration, const Sample& sample);

// Returns whether a late camera would explain what was found, and more frames in a row are needed
// to say whether it is one: rows or signs are wrong, and not by the same in all frames.
bool MayBeLate(const StereoJudgement& judgement);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_STEREO_CHECKS_H_
