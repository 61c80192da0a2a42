#include "services/observe/logging/json_log_sink.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

// Takes "NAME=VALUE " from the front of the message. Returns false if the message begins with
// something else.
bool TakeField(absl::string_view name, absl::string_view& message, std::string& value) {
  absl::string_view rest = message;
  if (!absl::ConsumePrefix(&rest, absl::StrCat(name, "="))) return false;
  const size_t end = rest.find(' ');
  if (end == 0 || end == absl::string_view::npos) return false;
  value = std::string(rest.substr(0, end));
  message = rest.substr(end + 1);
  return true;
}

}  // namespace

std::string LogLineToJson(google::LogSeverity severity, absl::string_view file, int line,
                          absl::Time time, absl::string_view message) {
  nlohmann::ordered_json object = {
      {"time", absl::FormatTime("%Y-%m-%dT%H:%M:%E6SZ", time, absl::UTCTimeZone())},
      {"severity", google::GetLogSeverityName(severity)},
      {"file", std::string(file)},
      {"line", line}};
  for (const char* name : {"mission", "agent"}) {
    std::string value;
    if (TakeField(name, message, value)) object[name] = value;
  }
  object["message"] = std::string(message);
  return object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void JsonLogSink::send(google::LogSeverity severity, const char*, const char* base_filename,
                       int line, const google::LogMessageTime& time, const char* message,
                       size_t message_len) {
  const absl::Time at = absl::FromTimeT(time.timestamp()) + absl::Microseconds(time.usec());
  const std::string text =
      LogLineToJson(severity, base_filename, line, at, absl::string_view(message, message_len)) +
      "\n";
  absl::MutexLock lock(&mutex_);
  std::fwrite(text.data(), 1, text.size(), out_);
  std::fflush(out_);
}

}  // namespace corbslam::services
