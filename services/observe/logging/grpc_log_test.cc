#include "services/observe/logging/grpc_log.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <grpc/support/log.h>
#include <gtest/gtest.h>

#include <vector>

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;

TEST(GrpcLinesTest, APlaceThatRepeatsItselfIsCounted) {
  GrpcLines lines;
  const absl::Time start = absl::FromUnixSeconds(1000);
  EXPECT_EQ(lines.Add("tcp.cc", 7, "no route", start), "no route");
  EXPECT_EQ(lines.Add("tcp.cc", 7, "no route", start + absl::Seconds(1)), std::nullopt);
  EXPECT_EQ(lines.Add("tcp.cc", 7, "no route", start + absl::Seconds(2)), std::nullopt);
  EXPECT_EQ(lines.Add("tcp.cc", 8, "another", start + absl::Seconds(2)), "another");
  EXPECT_EQ(lines.Add("tcp.cc", 7, "no route", start + absl::Seconds(61)),
            "no route (and 2 lines like it since the last one)");
  EXPECT_EQ(lines.Add("tcp.cc", 7, "no route", start + absl::Seconds(62)), std::nullopt);
  EXPECT_EQ(lines.Add("tcp.cc", 7, "no route", start + absl::Seconds(300)),
            "no route (and 1 line like it since the last one)");
}

class Sink : public google::LogSink {
 public:
  Sink() { google::AddLogSink(this); }
  ~Sink() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity severity, const char*, const char* file, int line,
            const google::LogMessageTime&, const char* message, size_t length) override {
    lines.push_back(std::string(google::GetLogSeverityName(severity)) + " " + file + ":" +
                    std::to_string(line) + " " + std::string(message, length));
  }
  std::vector<std::string> lines;
};

TEST(GrpcLogTest, ErrorsOfGrpcAreWarningsOfOurs) {
  Sink sink;
  SendGrpcLinesToLog();
  gpr_set_log_verbosity(GPR_LOG_SEVERITY_ERROR);
  gpr_log("src/core/tcp.cc", 12, GPR_LOG_SEVERITY_ERROR, "can't bind %d", 3);
  // Nobody asked for these.
  gpr_log("src/core/tcp.cc", 13, GPR_LOG_SEVERITY_DEBUG, "a byte came");
  EXPECT_THAT(sink.lines, ElementsAre("WARNING tcp.cc:12 gRPC: can't bind 3"));
  gpr_set_log_function(nullptr);
}

}  // namespace
}  // namespace corbslam::services
