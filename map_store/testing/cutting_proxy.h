// Stands between a client and a server on this machine, and cuts connections at moments that a test
// chooses.
#ifndef CORBSLAM_MAP_STORE_TESTING_CUTTING_PROXY_H_
#define CORBSLAM_MAP_STORE_TESTING_CUTTING_PROXY_H_

#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::testing {

// Thread-safe.
class CuttingProxy {
 public:
  explicit CuttingProxy(int server_port);
  ~CuttingProxy();

  int port() const { return port_; }

  enum class Moment {
    kNever,
    kBefore,  // The words have come from a client, and the server never gets them.
    kAfter,   // The server has answered them, and the client never gets the answer.
  };
  // Cuts, `times` times, a connection whose client sends these words.
  void CutAt(const std::string& words, Moment moment, int times = 1) ABSL_LOCKS_EXCLUDED(mutex_);
  int cuts() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Pair {
    int client = -1;
    int server = -1;
    bool is_doomed = false;  // The server's next answer is the end.
  };

  void Run();
  void Accept();
  // Return whether the connection goes on.
  bool PassOn(Pair& pair);
  bool PassBack(Pair& pair);
  // Returns what is to happen to a client that has sent these bytes.
  Moment Judge(const std::string& bytes) ABSL_LOCKS_EXCLUDED(mutex_);

  const int server_port_;
  int listener_ = -1;
  int port_ = 0;
  int wake_[2] = {-1, -1};
  std::vector<Pair> pairs_;  // The thread's.

  mutable absl::Mutex mutex_;
  std::string words_ ABSL_GUARDED_BY(mutex_);
  Moment moment_ ABSL_GUARDED_BY(mutex_) = Moment::kNever;
  int times_ ABSL_GUARDED_BY(mutex_) = 0;
  int cuts_ ABSL_GUARDED_BY(mutex_) = 0;

  std::thread thread_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_CUTTING_PROXY_H_
