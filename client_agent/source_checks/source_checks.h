// Finds all that can be told about a source from a sample of its frames, before it is played.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SOURCE_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SOURCE_CHECKS_H_

#include <vector>

#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"
#include "client_agent/source_checks/stereo_checks.h"

namespace corbslam::client_agent {

// Calls CheckPictures, and JudgeStereoPair or CheckDepth as the calibration says. Where the
// pictures by themselves show an error, only that is told, and no pair is judged. Pure; any thread.
StereoJudgement JudgeSample(const SensorCalibration& calibration, const Sample& sample);

// Returns what the source's files and a sample of the frames that `spec` selects show: the reader's
// own findings, then those of JudgeSample, then frames of the sample that can't be read. A source
// of a registered kind is not looked into: what a simulation draws is as it was asked for.
// Thread-safe; decodes the sample's pictures.
SourceFindings InspectSource(const FrameReader& reader, const SourceSpec& spec,
                             const SampleOptions& options = {});

// What a look at a source gives: the sample, those of its frames that can be read, and what it
// showed.
struct Inspection {
  Sample sample;
  SourceFindings findings;
  std::vector<JudgedPair> pairs;  // Of a stereo source.
};

// Does what InspectSource does. The sample of a source of a registered kind is read, and not
// checked.
Inspection LookIntoSource(const FrameReader& reader, const SourceSpec& spec,
                          const SampleOptions& options = {});

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SOURCE_CHECKS_H_
