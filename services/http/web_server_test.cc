// Tests a web server as browsers meet it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "services/http/browser_options.h"
#include "services/http/testing/raw_http.h"
#include "services/http/testing/web_client.h"
#include "services/security/pem_files.h"
#include "services/security/testing/test_certificates.h"

namespace corbslam::services {
namespace {

using testing::Ask;
using testing::BodyOf;
using ::testing::HasSubstr;
using testing::MakeRequest;
using ::testing::Not;
using testing::RawConnection;
using testing::StatusOf;
using testing::WebSocketClient;

// Streams what is pushed; answers with what was asked.
class Echo : public WebHandler {
 public:
  void Answer(const WebRequest& request, Respond respond) override {
    WebResponse response;
    response.body = std::make_shared<const std::string>(absl::StrCat(
        request.method, " ", request.path, " ", request.authorization, " ", request.takes_gzip));
    if (request.path != "/later") return respond(response);
    absl::MutexLock lock(&mutex_);
    later_.emplace_back([respond, response] { respond(response); });
  }

  OpenedStream Open(const WebRequest& request, std::function<void()> wake) override {
    if (request.path != "/stream") return {nullptr, 4404, "there is no such stream"};
    absl::MutexLock lock(&mutex_);
    wakers_.push_back(std::move(wake));
    ++streams_;
    return {std::make_unique<Stream>(this), 0, ""};
  }

  void Push(const std::string& message) {
    std::vector<std::function<void()>> wakers;
    {
      absl::MutexLock lock(&mutex_);
      waiting_.push_back(std::make_shared<const std::string>(message));
      wakers = wakers_;
    }
    for (const auto& wake : wakers) wake();
  }
  void AnswerLate() {
    absl::MutexLock lock(&mutex_);
    mutex_.Await(absl::Condition(this, &Echo::IsAnswerWaiting));
    for (const auto& answer : later_) answer();
  }
  void WaitUntilStreams(int count) {
    absl::MutexLock lock(&mutex_);
    const auto reached = [this, count]()
                             ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return streams_ == count; };
    mutex_.Await(absl::Condition(&reached));
  }

 private:
  class Stream : public WebStream {
   public:
    explicit Stream(Echo* echo) : echo_(*echo) {}
    ~Stream() override {
      absl::MutexLock lock(&echo_.mutex_);
      --echo_.streams_;
    }
    std::shared_ptr<const std::string> Next() override {
      absl::MutexLock lock(&echo_.mutex_);
      if (echo_.waiting_.empty()) return nullptr;
      auto message = echo_.waiting_.front();
      echo_.waiting_.pop_front();
      return message;
    }

   private:
    Echo& echo_;
  };

  bool IsAnswerWaiting() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !later_.empty(); }

  absl::Mutex mutex_;
  std::deque<std::shared_ptr<const std::string>> waiting_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::function<void()>> wakers_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::function<void()>> later_ ABSL_GUARDED_BY(mutex_);
  int streams_ ABSL_GUARDED_BY(mutex_) = 0;
};

class WebServerTest : public ::testing::Test {
 protected:
  void Start(const WebServerOptions& options = BrowserOptions()) {
    auto server = WebServer::Start("127.0.0.1:0", &echo_, options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  const std::string& address() const { return server_->address(); }
  std::string Get(const std::string& target, const std::string& headers = "") {
    return Ask(address(), MakeRequest("GET", target, headers + "Connection: close\r\n"));
  }
  // Returns the answer to the handshake of a WebSocket.
  std::string AskForSocket(const std::string& headers) {
    return Ask(address(),
               MakeRequest("GET", "/stream",
                           absl::StrCat("Connection: Upgrade\r\nUpgrade: websocket\r\n"
                                        "Sec-WebSocket-Version: 13\r\n"
                                        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n",
                                        headers)));
  }

  Echo echo_;
  std::unique_ptr<WebServer> server_;
};

TEST_F(WebServerTest, AnswersRequestAfterRequestOnOneConnection) {
  Start();
  RawConnection connection(address());
  ASSERT_TRUE(connection.Send(MakeRequest("GET", "/a?b=c", "Authorization: Bearer x\r\n")));
  ASSERT_TRUE(connection.Send(
      MakeRequest("GET", "/d%20e", "Accept-Encoding: br, gzip\r\nConnection: close\r\n")));
  const std::string answers = connection.ReadToEnd();
  EXPECT_THAT(answers, HasSubstr("GET /a Bearer x 0"));
  EXPECT_THAT(answers, HasSubstr("GET /d e  1"));
}

TEST_F(WebServerTest, RefusesWhatItDoesNotTake) {
  Start();
  EXPECT_EQ(StatusOf(Get("/%zz")), 400);
  EXPECT_EQ(StatusOf(Get("/", absl::StrCat("X: ", std::string(9000, 'x'), "\r\n"))), 200);
  EXPECT_EQ(StatusOf(Get("/", absl::StrCat("X: ", std::string(20000, 'x'), "\r\n"))), 431);
  EXPECT_EQ(StatusOf(Get("/fine")), 200);
}

TEST_F(WebServerTest, ABodyIsNotReadAndIsNoNextRequest) {
  Start();
  const std::string body = MakeRequest("GET", "/body");
  for (const char* length : {"Content-Length: 28\r\n", "Transfer-Encoding: chunked\r\n"}) {
    const std::string answers = Ask(address(), MakeRequest("POST", "/a", length) + body);
    EXPECT_EQ(StatusOf(answers), 200);
    EXPECT_THAT(answers, HasSubstr("Connection: close\r\n"));
    EXPECT_THAT(answers, Not(HasSubstr("/body")));
  }
}

TEST_F(WebServerTest, AnswersMayComeLaterFromOtherThreads) {
  Start();
  std::thread thread([this] { echo_.AnswerLate(); });
  EXPECT_THAT(BodyOf(Get("/later")), HasSubstr("GET /later"));
  thread.join();
}

TEST_F(WebServerTest, AnAnswerThatComesAfterTheEndIsNobodys) {
  Start();
  RawConnection connection(address());
  ASSERT_TRUE(connection.Send(MakeRequest("GET", "/later")));
  EXPECT_EQ(StatusOf(Get("/fine")), 200);
  server_.reset();
  echo_.AnswerLate();
}

TEST_F(WebServerTest, StreamsMessagesInOrder) {
  Start();
  WebSocketClient client(address(), "/stream");
  ASSERT_TRUE(client.stands());
  EXPECT_EQ(client.protocol(), "corbslam");
  for (int i = 0; i < 100; ++i) echo_.Push(absl::StrCat("message ", i, std::string(1000, '.')));
  for (int i = 0; i < 100; ++i) {
    const auto message = client.Read();
    ASSERT_TRUE(message);
    EXPECT_THAT(*message, HasSubstr(absl::StrCat("message ", i, ".")));
  }
  // What a page says is passed over.
  EXPECT_TRUE(client.Send("hello"));
  echo_.Push("after");
  EXPECT_EQ(client.Read(), "after");
}

TEST_F(WebServerTest, AStreamEndsWithItsPage) {
  Start();
  {
    WebSocketClient client(address(), "/stream");
    ASSERT_TRUE(client.stands());
    echo_.WaitUntilStreams(1);
  }
  echo_.WaitUntilStreams(0);
  echo_.Push("to nobody");
}

TEST_F(WebServerTest, SaysWhyThereIsNoStream) {
  Start();
  WebSocketClient none(address(), "/nothing");
  ASSERT_TRUE(none.stands());
  EXPECT_FALSE(none.Read());
  EXPECT_EQ(none.close_code(), 4404);
}

TEST_F(WebServerTest, StreamsAreBounded) {
  WebServerOptions options = BrowserOptions();
  options.max_streams = 1;
  Start(options);
  WebSocketClient first(address(), "/stream");
  ASSERT_TRUE(first.stands());
  EXPECT_EQ(StatusOf(AskForSocket("")), 503);
}

TEST_F(WebServerTest, PagesOfOtherSitesReadNothing) {
  Start();
  EXPECT_EQ(StatusOf(AskForSocket("Origin: http://evil.example\r\n")), 403);
  WebSocketClient own(address(), "/stream", {.origin = absl::StrCat("http://", address())});
  EXPECT_TRUE(own.stands());
}

TEST_F(WebServerTest, ANameThatLeadsHereByRebindingReadsNothing) {
  WebServerOptions options = BrowserOptions();
  options.hosts = std::vector<std::string>{"viewer.lan"};
  Start(options);
  const auto ask = [this](const std::string& host) {
    return Ask(address(),
               absl::StrCat("GET /a HTTP/1.1\r\nHost: ", host, "\r\nConnection: close\r\n\r\n"));
  };
  EXPECT_EQ(StatusOf(ask(address())), 200);
  EXPECT_EQ(StatusOf(ask("viewer.lan:80")), 200);
  const std::string refusal = ask("evil.example:80");
  EXPECT_EQ(StatusOf(refusal), 421);
  EXPECT_THAT(BodyOf(refusal), HasSubstr("\"evil.example:80\""));
  EXPECT_THAT(refusal, Not(HasSubstr("GET /a")));
  // Its page's origin would be its own here: a WebSocket is refused for the name, too.
  EXPECT_EQ(StatusOf(AskForSocket("Origin: http://x\r\n")), 421);
  WebSocketClient own(address(), "/stream", {.origin = absl::StrCat("http://", address())});
  EXPECT_TRUE(own.stands());
}

TEST_F(WebServerTest, WhoSaysNothingIsClosed) {
  WebServerOptions options = BrowserOptions();
  options.patience = absl::Milliseconds(200);
  Start(options);
  RawConnection connection(address());
  EXPECT_EQ(connection.ReadToEnd(), "");
  EXPECT_TRUE(connection.has_ended());
  // Nor does one stay that has asked before.
  EXPECT_EQ(StatusOf(Ask(address(), MakeRequest("GET", "/a"))), 200);
}

TEST_F(WebServerTest, ServesWithTls) {
  const test_data::TestCertificates certificates("lab");
  auto pair = ReadKeyPair(certificates.Options("store").certificate_file,
                          certificates.Options("store").key_file);
  ASSERT_TRUE(pair.ok()) << pair.status();
  Start(BrowserOptions(*WebTls::Make(pair->certificate_pem, pair->key_pem)));
  WebSocketClient client(address(), "/stream", {.tls = true});
  ASSERT_TRUE(client.stands());
  echo_.Push("secret");
  EXPECT_EQ(client.Read(), "secret");
  EXPECT_FALSE(WebSocketClient(address(), "/stream").stands());
}

TEST(WebServerStartTest, SaysWhatIsWrong) {
  Echo echo;
  EXPECT_EQ(WebServer::Start("nowhere", &echo).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(WebTls::Make("no certificate", "no key").status().message(),
              HasSubstr("key pair can't be used"));
}

}  // namespace
}  // namespace corbslam::services
