// Reads what an IMU measured, in EuRoC's form: "time in nanoseconds,wx,wy,wz,ax,ay,az" a line.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_IMU_LIST_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_IMU_LIST_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

// Reads a list with or without a line of headings; fields are apart by commas, semicolons, tabs or
// blanks. Samples come in the order of time, one of each time; another order and repeated times are
// warnings in `remarks`. Returns INVALID_ARGUMENT, naming the line, for a field that is no finite
// number, other than seven fields, a time that is not in whole nanoseconds or jumps back by more
// than a second; and where headings say other units or another order of fields, or more than a
// tenth of the times are out of order or repeated.
absl::StatusOr<ImuSamples> ReadImuList(const std::string& path, SourceRemarks& remarks);

// Does the same without judging times: samples are in the order of the file.
absl::StatusOr<ImuSamples> ReadImuLines(const std::string& path);

// Puts samples in the order of time and takes each time once, with a warning; `from` names where
// they are from. INVALID_ARGUMENT where that is more than a tenth of them.
absl::Status PutInOrder(const std::string& from, ImuSamples& samples, SourceFindings& findings);

// Returns the samples later than `after_ns`, up to the first one at or after `until_ns`. That one
// is left out where it is more than kMostAheadOfPicture later: behind a gap it is the next frame's.
ImuSamples ImuBetween(const ImuSamples& samples, int64_t after_ns, int64_t until_ns);
inline constexpr int64_t kMostAheadOfPicture_ns = 100'000'000;

// Adds to every time.
void ShiftTimes(int64_t by_ns, ImuSamples& samples);

// The heading of lists and a sample's line, as EuRoC's files have them; numbers are read back to
// the bit.
inline constexpr char kImuHeading[] =
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m "
    "s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]";
std::string FormatImuLine(const ImuSample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_IMU_LIST_H_
