// Tests a web server as operators and strangers meet it, by bytes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "services/http/testing/raw_http.h"
#include "services/http/web_server.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using testing::Ask;
using testing::BodyOf;
using ::testing::HasSubstr;
using testing::MakeRequest;
using ::testing::MatchesRegex;
using testing::RawConnection;
using testing::StatusOf;

constexpr char kAnyPort[] = "127.0.0.1:0";

using AnswerOf = std::function<WebResponse(const WebRequest&)>;

// Answers by a function.
class Answering : public WebHandler {
 public:
  explicit Answering(AnswerOf answer) : answer_(std::move(answer)) {}
  void Answer(const WebRequest& request, Respond respond) override { respond(answer_(request)); }

 private:
  const AnswerOf answer_;
};

WebResponse Text(std::string body) {
  return {.body = std::make_shared<const std::string>(std::move(body))};
}

WebResponse Repeat(const WebRequest& request) {
  return Text(absl::StrCat(request.method, " ", request.path));
}

class WebRequestsTest : public ::testing::Test {
 protected:
  void Start(const AnswerOf& answer, const WebServerOptions& options = {}) {
    handler_ = std::make_unique<Answering>(answer);
    auto server = WebServer::Start(kAnyPort, handler_.get(), options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  const std::string& address() const { return server_->address(); }
  std::string Get(const std::string& target) const {
    return BodyOf(Ask(address(), MakeRequest("GET", target)));
  }

  std::unique_ptr<Answering> handler_;
  std::unique_ptr<WebServer> server_;
};

TEST_F(WebRequestsTest, AnswersARequestAndCloses) {
  Start(Repeat);
  EXPECT_THAT(address(), MatchesRegex("127.0.0.1:[1-9][0-9]*"));
  const std::string answer = Ask(address(), MakeRequest("GET", "/here"));
  EXPECT_EQ(StatusOf(answer), 200) << answer;
  EXPECT_EQ(BodyOf(answer), "GET /here");
  EXPECT_THAT(answer, AllOf(HasSubstr("Content-Length: 9\r\n"), HasSubstr("Connection: close\r\n"),
                            HasSubstr("Content-Type: text/plain; charset=utf-8\r\n")));
}

TEST_F(WebRequestsTest, FindsThePathInWhateverStandsThere) {
  Start(Repeat);
  EXPECT_EQ(Get("/a/b?c=d#e"), "GET /a/b");
  EXPECT_EQ(Get("http://host:1234/a?b"), "GET /a");
  EXPECT_EQ(Get("http://host"), "GET /");
  EXPECT_EQ(Get("/a://b/c"), "GET /a://b/c");
  EXPECT_EQ(Get("*"), "GET *");
  EXPECT_EQ(BodyOf(Ask(address(), "POST / HTTP/1.0\r\n\r\n")), "POST /");
  EXPECT_EQ(BodyOf(Ask(address(), MakeRequest("BREW", "/pot"))), "BREW /pot");
}

TEST_F(WebRequestsTest, TellsHeadTheLengthAndSendsNoBody) {
  Start(Repeat);
  const std::string answer = Ask(address(), MakeRequest("HEAD", "/here"));
  EXPECT_EQ(StatusOf(answer), 200);
  EXPECT_THAT(answer, HasSubstr("Content-Length: 10\r\n"));
  EXPECT_EQ(BodyOf(answer), "");
}

TEST_F(WebRequestsTest, ALongAnswerArrivesWholeAlsoWhereABodyWasNotRead) {
  Start([](const WebRequest&) { return Text(std::string(3 << 20, 'x')); });
  RawConnection connection(address());
  ASSERT_TRUE(connection.Send(MakeRequest("POST", "/", "Content-Length: 100000\r\n")));
  EXPECT_TRUE(connection.Send(std::string(100000, 'y')));
  EXPECT_EQ(BodyOf(connection.ReadToEnd()).size(), size_t{3 << 20});
}

TEST_F(WebRequestsTest, RefusesWhatIsNoRequest) {
  Start(Repeat);
  const struct {
    std::string what;
    std::string bytes;
    int status;
  } cases[] = {
      {"no HTTP", "hello\r\n\r\n", 400},
      {"HTTP/0.9", "GET /\r\n\r\n", 400},
      {"HTTP/2", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 400},
      {"another version", "GET / HTTP/9.9\r\n\r\n", 400},
      {"TLS", std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 15), 400},
      {"zeros", std::string(100, '\0') + "\r\n\r\n", 400},
      {"a header without a name", MakeRequest("GET", "/", ": x\r\n"), 400},
      {"a header with control characters", MakeRequest("GET", "/", "A: \x01\r\n"), 400},
      {"two lengths", MakeRequest("POST", "/", "Content-Length: 1\r\nContent-Length: 2\r\n"), 400},
      {"a length below zero", MakeRequest("POST", "/", "Content-Length: -1\r\n"), 400},
      {"a long target", MakeRequest("GET", "/" + std::string(20000, 'a')), 414},
      {"a line without an end", std::string(1 << 20, 'a'), 414},
      {"a long header",
       MakeRequest("GET", "/", absl::StrCat("A: ", std::string(9000, 'b'), "\r\n")), 431},
      {"a header without an end", "GET / HTTP/1.1\r\nA: " + std::string(1 << 20, 'b'), 431},
  };
  for (const auto& one : cases) {
    EXPECT_EQ(StatusOf(Ask(address(), one.bytes)), one.status) << one.what;
  }
  std::string many;
  for (int i = 0; i < 100000; ++i) absl::StrAppend(&many, "A", i, ": b\r\n");
  EXPECT_EQ(StatusOf(Ask(address(), MakeRequest("GET", "/", many))), 431);
  EXPECT_EQ(Get("/still"), "GET /still");
}

TEST_F(WebRequestsTest, TakesWhateverHeadersSayOfABodyOrOfAnotherProtocol) {
  Start(Repeat);
  for (const char* headers :
       {"Content-Length: 9223372036854775807\r\n", "Transfer-Encoding: chunked\r\n",
        "Expect: 100-continue\r\nContent-Length: 5\r\n", "Connection: Upgrade\r\nUpgrade: h2c\r\n",
        "Connection: keep-alive\r\n", "Range: bytes=0-0,0-0,0-0,0-0,0-0\r\n",
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: eA==\r\n"}) {
    EXPECT_EQ(BodyOf(Ask(address(), MakeRequest("GET", "/", headers))), "GET /") << headers;
  }
}

TEST_F(WebRequestsTest, WhoEndsSendingBeforeARequestIsThereIsLeft) {
  Start(Repeat);
  for (const char* bytes : {"", "G", "GET / HTTP/1.1\r\nA: b\r\n"}) {
    RawConnection connection(address());
    EXPECT_TRUE(connection.Send(bytes));
    connection.EndSending();
    EXPECT_EQ(connection.ReadToEnd(), "");
    EXPECT_TRUE(connection.has_ended()) << bytes;
  }
  RawConnection half(address());
  half.Send(MakeRequest("GET", "/"));
  half.EndSending();
  EXPECT_EQ(BodyOf(half.ReadToEnd()), "GET /") << "the rest is still wanted";
}

TEST_F(WebRequestsTest, SlowClientsEndInTimeAndNobodyWaitsForThem) {
  Start(Repeat, {.first_patience = absl::Seconds(1)});
  RawConnection silent(address());
  RawConnection slow(address());
  ASSERT_TRUE(slow.Send("GET / HT"));
  EXPECT_EQ(Get("/others"), "GET /others");
  EXPECT_EQ(silent.ReadToEnd(), "");
  EXPECT_TRUE(silent.has_ended());
  EXPECT_EQ(slow.ReadToEnd(), "");
  EXPECT_TRUE(slow.has_ended());
}

TEST_F(WebRequestsTest, WhoDoesNotReadTheAnswerEndsInTime) {
  constexpr size_t kMoreThanSocketsHold = 64 << 20;
  constexpr absl::Duration kMaxTime = absl::Seconds(1);
  const auto answer = [](const WebRequest& request) {
    return Text(std::string(request.path == "/long" ? kMoreThanSocketsHold : 1, 'x'));
  };
  Start(answer, {.first_patience = kMaxTime});
  RawConnection first(address());
  first.Send(MakeRequest("GET", "/long"));
  EXPECT_EQ(Get("/short"), "x") << "while the first one's answer stands still";
  // The client reads only after its time: one that reads now may be quick enough to get all.
  absl::SleepFor(3 * kMaxTime);
  EXPECT_LT(first.ReadToEnd().size(), kMoreThanSocketsHold);
  EXPECT_TRUE(first.has_ended());
}

TEST_F(WebRequestsTest, ManyConnectionsMakeRoomForTheNext) {
  Start(Repeat, {.connections = {.all = 4, .of_host = 4},
                 .first_patience = absl::Hours(1),
                 .patience = absl::Hours(1)});
  std::vector<RawConnection> idle;
  for (int i = 0; i < 100; ++i) {
    idle.emplace_back(address());
    ASSERT_TRUE(idle.back().is_connected());
  }
  EXPECT_EQ(Get("/here"), "GET /here");
  for (size_t i = 0; i + 4 < idle.size(); ++i) {
    idle[i].ReadToEnd();
    EXPECT_TRUE(idle[i].has_ended()) << i;
  }
  EXPECT_EQ(idle.back().ReadToEnd(absl::ZeroDuration()), "");
  EXPECT_FALSE(idle.back().has_ended()) << "one of the youngest stays";
}

TEST_F(WebRequestsTest, WithoutFileDescriptorsItWaitsForOne) {
  Start(Repeat);
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  RawConnection connection(address());
  // The system has connected the client; whether the server has taken the connection already
  // doesn't matter.
  rlimit none = before;
  none.rlim_cur = 3;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  connection.Send(MakeRequest("GET", "/"));
  connection.ReadToEnd(absl::Milliseconds(300));
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(Get("/again"), "GET /again");
}

TEST_F(WebRequestsTest, WhatTheHandlerThrowsIsAnswered) {
  Start([](const WebRequest&) -> WebResponse { throw std::runtime_error("secret"); });
  const std::string answer = Ask(address(), MakeRequest("GET", "/"));
  EXPECT_EQ(StatusOf(answer), 500);
  EXPECT_EQ(answer.find("secret"), std::string::npos);
}

TEST_F(WebRequestsTest, EndsWithoutWaitingForClients) {
  Start(Repeat, {.first_patience = absl::Hours(1), .patience = absl::Hours(1)});
  RawConnection silent(address());
  EXPECT_EQ(Get("/"), "GET /");
  server_.reset();
  silent.ReadToEnd();
  EXPECT_TRUE(silent.has_ended());
}

TEST_F(WebRequestsTest, ItsThreadHasLessOfAProcessor) {
  int niceness = 0;
  Start([&niceness](const WebRequest&) {
    niceness = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
    return WebResponse();
  });
  Get("/");
  EXPECT_EQ(niceness, std::min(19, getpriority(PRIO_PROCESS, 0) + 5));
}

TEST_F(WebRequestsTest, TwoDoNotShareAPortAndItIsSaidWhoHasIt) {
  Start(Repeat);
  const auto second = WebServer::Start(address(), handler_.get());
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()),
              AllOf(HasSubstr(address()), HasSubstr("this process itself has this port")));
}

TEST_F(WebRequestsTest, ThePortIsFreeAgainAtOnce) {
  Start(Repeat);
  const std::string before = address();
  EXPECT_EQ(Get("/"), "GET /");
  server_.reset();
  const auto again = WebServer::Start(before, handler_.get());
  EXPECT_TRUE(again.ok()) << again.status();
}

TEST(HttpAddressTest, IsAnIpAddressAndAPort) {
  Answering handler(Repeat);
  for (const char* good : {"127.0.0.1:0", "0.0.0.0:65535", "[::1]:9464", "[::]:0"}) {
    EXPECT_TRUE(CheckHttpAddress(good).ok()) << good;
  }
  for (const char* bad : {"", "9464", ":9464", "127.0.0.1", "127.0.0.1:", "127.0.0.1:x",
                          "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:+1", "::1:9464", "1.2.3:1",
                          "localhost:9464", "[127.0.0.1]:1", "[::1:1", "127.0.0.1:1,0.0.0.0:2"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(CheckHttpAddress(bad))) << bad;
    EXPECT_TRUE(absl::IsInvalidArgument(WebServer::Start(bad, &handler).status())) << bad;
  }
}

}  // namespace
}  // namespace corbslam::services
