// Asks a map store whether it has revoked browsers' tokens.
#ifndef CORBSLAM_SERVICES_VIEWER_TOKEN_WATCH_H_
#define CORBSLAM_SERVICES_VIEWER_TOKEN_WATCH_H_

#include <grpcpp/channel.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {

// Shows the store each token that browsers have shown of late, every two seconds, on a thread of
// its own. That the store revokes one counts here, too; what else it says of tokens does not, since
// it may go by another name (--token-audience). As long as it does not answer, its last word
// counts. Thread-safe.
class TokenWatch {
 public:
  static constexpr absl::Duration kInterval = absl::Seconds(2);

  // The channel must bring no token of its own. Null: nobody is asked.
  explicit TokenWatch(const std::shared_ptr<grpc::Channel>& store,
                      absl::Duration interval = kInterval);
  ~TokenWatch();
  TokenWatch(const TokenWatch&) = delete;
  TokenWatch& operator=(const TokenWatch&) = delete;

  // Returns UNAUTHENTICATED, in the store's words, if it has revoked the token. One that was not
  // asked about yet is asked about from now on; `token` must be good by what the viewer itself
  // knows.
  absl::Status Check(const std::string& id, const std::string& token, const std::string& mission)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Does the same, and waits for the store's answer where there is none yet.
  absl::Status AskAndCheck(const std::string& id, const std::string& token,
                           const std::string& mission) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Token {
    std::string text;
    std::string mission;
    absl::Time last_shown;
    bool is_answered = false;
    absl::Status revoked;
  };

  void Run();
  // Asks about one token, without the lock.
  void Ask(const std::string& id, const std::string& token, const std::string& mission)
      ABSL_LOCKS_EXCLUDED(mutex_);

  const std::unique_ptr<v1::MapStore::Stub> store_;
  const absl::Duration interval_;
  absl::Notification stop_;
  absl::Mutex mutex_;
  std::map<std::string, Token> tokens_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_TOKEN_WATCH_H_
