// Says whom a line of the log is about, always in the same words.
#ifndef CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FIELDS_H_
#define CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FIELDS_H_

#include <ostream>
#include <string>

namespace corbslam::services {

// Fields to be put first: LOG(INFO) << LogFields{.mission = m, .agent = a} << "session opened"
// writes "mission=m agent=a session opened"; as JSON they are members of these names. Values have
// no spaces (names and ids never do); empty ones are left out.
struct LogFields {
  std::string mission = "";
  std::string agent = "";
};

inline std::ostream& operator<<(std::ostream& out, const LogFields& fields) {
  if (!fields.mission.empty()) out << "mission=" << fields.mission << ' ';
  if (!fields.agent.empty()) out << "agent=" << fields.agent << ' ';
  return out;
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FIELDS_H_
