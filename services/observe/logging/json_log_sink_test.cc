#include "services/observe/logging/json_log_sink.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "services/observe/logging/log_fields.h"

namespace corbslam::services {
namespace {

using nlohmann::json;

json Parse(absl::string_view message) {
  const absl::Time time = absl::FromUnixMicros(1'700'000'000'000'042);
  return json::parse(LogLineToJson(google::GLOG_WARNING, "sync.cc", 42, time, message));
}

TEST(LogLineToJsonTest, SaysWhenWhereAndWhat) {
  const json line = Parse("the disk is full");
  EXPECT_EQ(line, (json{{"time", "2023-11-14T22:13:20.000042Z"},
                        {"severity", "WARNING"},
                        {"file", "sync.cc"},
                        {"line", 42},
                        {"message", "the disk is full"}}));
}

TEST(LogLineToJsonTest, FieldsBecomeMembers) {
  std::ostringstream text;
  text << LogFields{.mission = "lab", .agent = "alpha"} << "session opened";
  EXPECT_EQ(text.str(), "mission=lab agent=alpha session opened");
  const json line = Parse(text.str());
  EXPECT_EQ(line["mission"], "lab");
  EXPECT_EQ(line["agent"], "alpha");
  EXPECT_EQ(line["message"], "session opened");
}

TEST(LogLineToJsonTest, FieldsMayBeLeftOutAndOthersStayInTheMessage) {
  std::ostringstream text;
  text << LogFields{.agent = "alpha"} << "mission=lab is what it wanted";
  const json line = Parse(text.str());
  EXPECT_FALSE(line.contains("mission"));
  EXPECT_EQ(line["agent"], "alpha");
  EXPECT_EQ(line["message"], "mission=lab is what it wanted");
  EXPECT_EQ(Parse("mission= nothing")["message"], "mission= nothing");
}

TEST(LogLineToJsonTest, IsOneLineWhateverTheMessageHolds) {
  const std::string message = "two\nlines, a \"quote\", a \\ and \xff no UTF-8";
  const std::string text = LogLineToJson(google::GLOG_INFO, "a.cc", 1, absl::UnixEpoch(), message);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  EXPECT_EQ(json::parse(text)["message"],
            "two\nlines, a \"quote\", a \\ and \xef\xbf\xbd no UTF-8");
}

TEST(JsonLogSinkTest, WritesWhatGlogSendsIt) {
  std::FILE* file = std::tmpfile();
  JsonLogSink sink(file);
  LOG_TO_SINK_BUT_NOT_TO_LOGFILE(&sink, ERROR) << LogFields{.mission = "lab"} << "lost " << 3;
  std::rewind(file);
  char text[1024] = {};
  ASSERT_NE(std::fgets(text, sizeof(text), file), nullptr);
  std::fclose(file);
  const json line = json::parse(text);
  EXPECT_EQ(line["severity"], "ERROR");
  EXPECT_EQ(line["file"], "json_log_sink_test.cc");
  EXPECT_EQ(line["mission"], "lab");
  EXPECT_EQ(line["message"], "lost 3");
  absl::Time time;
  std::string error;
  ASSERT_TRUE(
      absl::ParseTime("%Y-%m-%dT%H:%M:%E*SZ", line["time"].get<std::string>(), &time, &error))
      << error;
}

}  // namespace
}  // namespace corbslam::services
