#include "services/client/reachability/host_lookup.h"

#include <gtest/gtest.h>
#include <netinet/in.h>

#include <atomic>

#include "absl/synchronization/notification.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kPatience = absl::Seconds(20);

TEST(HostLookupTest, FindsLoopback) {
  const auto found = LookUpHost({"127.0.0.1", 4711}, kPatience);
  ASSERT_TRUE(found.ok()) << found.status();
  ASSERT_EQ(found->size(), 1u);
  const auto* address = reinterpret_cast<const sockaddr_in*>(&found->at(0).bytes);
  EXPECT_EQ(address->sin_family, AF_INET);
  EXPECT_EQ(ntohs(address->sin_port), 4711);
  EXPECT_EQ(ntohl(address->sin_addr.s_addr), INADDR_LOOPBACK);
}

TEST(HostLookupTest, PassesOnThatThereIsNone) {
  const auto none = [](const HostPort& address) -> absl::StatusOr<std::vector<SocketAddress>> {
    return absl::NotFoundError(address.host);
  };
  EXPECT_EQ(LookUpHost({"no.such.host", 1}, kPatience, none).status(),
            absl::NotFoundError("no.such.host"));
}

// A DNS server that does not answer holds up one thread, not one for each question.
TEST(HostLookupTest, DoesNotWaitForADnsThatHangs) {
  absl::Notification answer;
  std::atomic<int> started = 0;
  const auto hangs = [&](const HostPort&) -> absl::StatusOr<std::vector<SocketAddress>> {
    ++started;
    answer.WaitForNotification();
    return std::vector<SocketAddress>(3);
  };
  const HostPort slow = {"slow.lan", 1};
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(absl::IsDeadlineExceeded(LookUpHost(slow, absl::Milliseconds(1), hangs).status()));
  }
  answer.Notify();
  EXPECT_EQ(LookUpHost(slow, kPatience, hangs)->size(), 3u);
  // The first look-up counts, and another one if that had ended before the last question.
  EXPECT_LE(started, 2);
}

}  // namespace
}  // namespace corbslam::services
