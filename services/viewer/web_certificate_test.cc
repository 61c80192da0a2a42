// Tests that a viewer's certificate is replaced while browsers look.
#include "services/viewer/web_certificate.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "services/http/browser_options.h"
#include "services/http/testing/web_client.h"
#include "services/security/testing/test_certificates.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

using test_data::TestCertificates;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::WebSocketClient;

constexpr absl::Duration kPatience = absl::Seconds(20);
constexpr absl::Duration kInterval = absl::Milliseconds(20);

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Replace(const std::string& path, const std::string& text) {
  std::ofstream(path + ".new") << text;
  fs::rename(path + ".new", path);
}

// Keeps what is logged.
class LoggedLines : public google::LogSink {
 public:
  LoggedLines() { google::AddLogSink(this); }
  ~LoggedLines() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int, const google::LogMessageTime&,
            const char* message, size_t length) override {
    absl::MutexLock lock(&mutex_);
    lines_.emplace_back(message, length);
  }
  // Returns the first line with these words behind those that earlier calls returned; empty: none
  // came.
  std::string WaitFor(const std::string& words) {
    absl::MutexLock lock(&mutex_);
    const auto has_come = [this, &words]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      while (seen_ < lines_.size() && !absl::StrContains(lines_[seen_], words)) ++seen_;
      return seen_ < lines_.size();
    };
    if (!mutex_.AwaitWithTimeout(absl::Condition(&has_come), kPatience)) return "";
    return lines_[seen_++];
  }

 private:
  absl::Mutex mutex_;
  size_t seen_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<std::string> lines_ ABSL_GUARDED_BY(mutex_);
};

// Says to all streams what it is told to.
class Pushed : public WebHandler {
 public:
  void Answer(const WebRequest&, Respond respond) override { respond({}); }
  OpenedStream Open(const WebRequest&, std::function<void()> wake) override {
    absl::MutexLock lock(&mutex_);
    wakers_.push_back(std::move(wake));
    return {std::make_unique<Stream>(this), 0, ""};
  }
  void Push(const std::string& message) {
    std::vector<std::function<void()>> wakers;
    {
      absl::MutexLock lock(&mutex_);
      messages_.push_back(std::make_shared<const std::string>(message));
      wakers = wakers_;
    }
    for (const auto& wake : wakers) wake();
  }

 private:
  class Stream : public WebStream {
   public:
    explicit Stream(Pushed* all) : all_(*all) {}
    std::shared_ptr<const std::string> Next() override {
      absl::MutexLock lock(&all_.mutex_);
      return sent_ == all_.messages_.size() ? nullptr : all_.messages_[sent_++];
    }

   private:
    Pushed& all_;
    size_t sent_ = 0;
  };

  absl::Mutex mutex_;
  std::vector<std::function<void()>> wakers_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::shared_ptr<const std::string>> messages_ ABSL_GUARDED_BY(mutex_);
};

class WebCertificateTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto tls = WatchWebCertificate(certificate_, key_, kInterval);
    ASSERT_TRUE(tls.ok()) << tls.status();
    auto server = WebServer::Start("127.0.0.1:0", &pushed_, BrowserOptions(*tls));
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  // Returns the certificate that a new connection is shown.
  std::string Shown() const {
    return WebSocketClient(server_->address(), "/", {.tls = true}).certificate();
  }

  const TestCertificates ours_{"lab"};
  const std::string certificate_ = ours_.Path("map_viewer.pem");
  const std::string key_ = ours_.Path("map_viewer.key");
  const std::string first_ = TextOf(certificate_);
  const std::string first_key_ = TextOf(key_);
  LoggedLines log_;
  Pushed pushed_;
  std::unique_ptr<WebServer> server_;
};

TEST_F(WebCertificateTest, ANewConnectionIsShownTheNewOneAndAnOldStreamGoesOn) {
  WebSocketClient old_page(server_->address(), "/", {.tls = true});
  ASSERT_TRUE(old_page.stands());
  EXPECT_EQ(old_page.certificate(), first_);
  Replace(certificate_, TextOf(ours_.Path("store.pem")));
  Replace(key_, TextOf(ours_.Path("store.key")));
  ASSERT_NE(log_.WaitFor("web_certificate: new content is in force"), "");
  EXPECT_EQ(Shown(), TextOf(ours_.Path("store.pem")));
  pushed_.Push("still here");
  EXPECT_EQ(old_page.Read(), "still here");
}

TEST_F(WebCertificateTest, WhatCannotBeUsedIsSaidWithItsFileAndTheOldOneStays) {
  const struct {
    const std::string& path;
    std::string text;
    const char* why;
  } bad_files[] = {
      {key_, TextOf(ours_.Path("store.key")), "does not belong to"},
      {key_, first_key_.substr(0, first_key_.size() / 2), "holds no private key"},
      {certificate_, first_.substr(0, first_.size() / 2), "holds no certificate"},
      {certificate_, "", "can't be read or is empty"},
  };
  for (const auto& bad : bad_files) {
    const std::string good = TextOf(bad.path);
    Replace(bad.path, bad.text);
    EXPECT_THAT(log_.WaitFor(bad.why),
                AllOf(HasSubstr(bad.path == key_ ? "--web-key" : "--web-cert"), HasSubstr(bad.path),
                      HasSubstr("what was read before stays in force")));
    EXPECT_EQ(Shown(), first_);
    Replace(bad.path, good);
    EXPECT_NE(log_.WaitFor("web_certificate: good again"), "");
  }
  fs::remove(key_);
  EXPECT_THAT(log_.WaitFor("can't be read"), HasSubstr(key_));
  EXPECT_EQ(Shown(), first_);
}

// A chain is shown whole, and its first certificate is the server's.
TEST_F(WebCertificateTest, AChainIsTakenWithItsFirstCertificate) {
  Replace(certificate_, absl::StrCat(first_, TextOf(ours_.Path("ca.pem"))));
  ASSERT_NE(log_.WaitFor("web_certificate: new content is in force"), "");
  EXPECT_EQ(Shown(), first_);
}

TEST(WebCertificateStartTest, NamesFlagAndFile) {
  const TestCertificates ours("lab");
  EXPECT_THAT(WatchWebCertificate("/none.pem", ours.Path("store.key")).status().message(),
              HasSubstr("--web-cert /none.pem can't be read"));
  EXPECT_THAT(
      WatchWebCertificate(ours.Path("store.pem"), ours.Path("worker.key")).status().message(),
      AllOf(HasSubstr("--web-key"), HasSubstr("worker.key does not belong to")));
}

}  // namespace
}  // namespace corbslam::services
