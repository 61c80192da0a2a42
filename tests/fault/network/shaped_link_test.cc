#include "tests/fault/network/shaped_link.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <string>

#include "absl/time/clock.h"
#include "slam/util/status_macros.h"
#include "tests/fault/network/network_namespace.h"

namespace corbslam::tests {
namespace {

constexpr char kHere[] = "10.78.0.1";
constexpr char kThere[] = "10.78.0.2";
constexpr int kPort = 5000;  // A port in networks where nobody else is.

sockaddr_in Address(const char* text) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(kPort);
  inet_pton(AF_INET, text, &address.sin_addr);
  return address;
}

// The test sends datagrams, so that nothing is repaired.
class Socket {
 public:
  explicit Socket(const char* address) : file_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in own = Address(address);
    EXPECT_EQ(bind(file_, reinterpret_cast<const sockaddr*>(&own), sizeof(own)), 0);
    const timeval patience = {0, 500'000};
    setsockopt(file_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  }
  ~Socket() { close(file_); }

  void Send(const std::string& text, const char* to) const {
    const sockaddr_in address = Address(to);
    EXPECT_EQ(sendto(file_, text.data(), text.size(), 0,
                     reinterpret_cast<const sockaddr*>(&address), sizeof(address)),
              static_cast<ssize_t>(text.size()));
  }
  // Returns an empty text when nothing comes for half a second.
  std::string Receive() const {
    std::array<char, 2000> buffer;
    const ssize_t bytes = recv(file_, buffer.data(), buffer.size(), 0);
    return bytes < 0 ? "" : std::string(buffer.data(), static_cast<size_t>(bytes));
  }

 private:
  const int file_;
};

class ShapedLinkTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const absl::Status permitted = MakeNetworks();
    if (permitted.ok()) return;
    ASSERT_EQ(std::getenv("CI"), nullptr) << permitted;
    GTEST_SKIP() << "needs to be root on Linux: " << permitted;
  }

  absl::Status MakeNetworks() {
    ASSIGN_OR_RETURN(here_, NetworkNamespace::Create());
    ASSIGN_OR_RETURN(there_, NetworkNamespace::Create());
    return ShapedLink::Create({here_.get(), there_.get(), kHere, kThere}, {}).status();
  }

  void Connect(const LinkShape& shape) {
    auto link = ShapedLink::Create({.here = here_.get(),
                                    .there = there_.get(),
                                    .address_here = kHere,
                                    .address_there = kThere},
                                   shape);
    ASSERT_TRUE(link.ok()) << link.status();
    link_ = *std::move(link);
    EXPECT_TRUE(here_
                    ->Run([this] {
                      a_ = std::make_unique<Socket>(kHere);
                      return absl::OkStatus();
                    })
                    .ok());
    EXPECT_TRUE(there_
                    ->Run([this] {
                      b_ = std::make_unique<Socket>(kThere);
                      return absl::OkStatus();
                    })
                    .ok());
  }

  std::unique_ptr<NetworkNamespace> here_;
  std::unique_ptr<NetworkNamespace> there_;
  std::unique_ptr<ShapedLink> link_;
  std::unique_ptr<Socket> a_;
  std::unique_ptr<Socket> b_;
};

TEST_F(ShapedLinkTest, CarriesBothWaysWithItsDelay) {
  LinkShape shape;
  shape.delay = absl::Milliseconds(50);
  ASSERT_NO_FATAL_FAILURE(Connect(shape));
  const absl::Time start = absl::Now();
  a_->Send("question", kThere);
  EXPECT_EQ(b_->Receive(), "question");
  b_->Send("answer", kHere);
  EXPECT_EQ(a_->Receive(), "answer");
  EXPECT_GE(absl::Now() - start, absl::Milliseconds(100));
}

TEST_F(ShapedLinkTest, AnOutageSwallowsWithoutAWord) {
  LinkShape shape;
  shape.outage = absl::Seconds(1);
  ASSERT_NO_FATAL_FAILURE(Connect(shape));
  const absl::Time start = absl::Now();
  a_->Send("lost", kThere);
  EXPECT_EQ(b_->Receive(), "");
  absl::SleepFor(start + absl::Seconds(1.1) - absl::Now());
  a_->Send("there", kThere);
  EXPECT_EQ(b_->Receive(), "there");
}

TEST_F(ShapedLinkTest, ImpossibleLinksAreRefusedByName) {
  EXPECT_TRUE(absl::IsInvalidArgument(
      ShapedLink::Create({here_.get(), there_.get(), "here", kThere}, {}).status()));
  LinkShape shape;
  shape.loss = 2;
  EXPECT_TRUE(absl::IsInvalidArgument(
      ShapedLink::Create({here_.get(), there_.get(), kHere, kThere}, shape).status()));
}

}  // namespace
}  // namespace corbslam::tests
