#include "services/server/server.h"

#include <gmock/gmock.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "services/server/process_usage.h"

namespace corbslam {
namespace {

using ::testing::MatchesRegex;

// What grpc.health.v1.Health/Check answers, as bytes: field 1, SERVING = 1, NOT_SERVING = 2.
std::string CheckHealth(const std::shared_ptr<grpc::Channel>& channel) {
  grpc::GenericStub stub(channel);
  grpc::CompletionQueue queue;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
  // No service named: all of the server. Kept until the call is started.
  const grpc::Slice nothing;
  const grpc::ByteBuffer request(&nothing, 1);
  const auto call =
      stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &queue);
  call->StartCall();
  grpc::ByteBuffer response;
  grpc::Status status;
  call->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  grpc::Slice slice;
  return status.ok() && response.DumpToSingleSlice(&slice).ok()
             ? std::string(reinterpret_cast<const char*>(slice.begin()), slice.size())
             : status.error_message();
}

TEST(ServerTest, ChoosesAPortAndSaysItIsServing) {
  const auto server = Server::Start("127.0.0.1:0", {});
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_THAT((*server)->address(), MatchesRegex("127.0.0.1:[1-9][0-9]*"));
  const auto channel =
      grpc::CreateChannel((*server)->address(), grpc::InsecureChannelCredentials());
  EXPECT_EQ(CheckHealth(channel), "\x08\x01");
}

TEST(ServerTest, TwoServersDoNotShareAPort) {
  const auto first = Server::Start("127.0.0.1:0", {});
  ASSERT_TRUE(first.ok());
  const auto second = Server::Start((*first)->address(), {});
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
}

TEST(ServerTest, RefusesWhatIsNoAddress) {
  for (const char* address : {"127.0.0.1", "127.0.0.1:99999", "127.0.0.1:-1", "127.0.0.1:x"}) {
    EXPECT_EQ(Server::Start(address, {}).status().code(), absl::StatusCode::kInvalidArgument)
        << address;
  }
}

TEST(ServerTest, AnnouncesItsAddressForWhoeverStartedIt) {
  ::testing::internal::CaptureStdout();
  AnnounceAddress("127.0.0.1:12");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "listening on 127.0.0.1:12\n");
}

TEST(ProcessUsageTest, IsThatOfThisProcess) {
  const ProcessUsage usage = GetProcessUsage();
  EXPECT_GT(usage.peak_rss_bytes, 1u << 20);
  EXPECT_LT(usage.peak_rss_bytes, 1u << 30);
  EXPECT_GE(usage.cpu_s, 0);
}

}  // namespace
}  // namespace corbslam
