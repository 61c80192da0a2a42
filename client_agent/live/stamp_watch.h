// Tells the times of one camera from those that another clock stamped.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_STAMP_WATCH_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_STAMP_WATCH_H_

#include <chrono>
#include <cstdint>
#include <optional>

namespace corbslam::client_agent {

// Watches the stamps of one side's pictures. A few that another clock made (years ahead, or of the
// past) are left out, and what comes behind them goes on as before; where they stay, that clock is
// the camera's from now on. Not thread-safe.
class StampWatch {
 public:
  using Moment = std::chrono::steady_clock::time_point;
  // Two stamps may differ by so much more than the time between the arrivals of their pictures.
  static constexpr std::chrono::seconds kMostAhead{60};
  // So many pictures in a row, of times that grow, make another clock the camera's.
  static constexpr int kBeginAnew = 5;

  enum class Verdict {
    kTake,
    kLate,   // Not above the newest one that was taken.
    kAhead,  // Further ahead of it than time has passed.
    kAnew,   // To be taken: times go on by another clock.
  };

  // Judges the next stamp; `came` is when its picture did.
  Verdict Judge(int64_t stamp_ns, Moment came);
  // Forgets all: the next stamp is taken, whatever it is.
  void Reset() { *this = StampWatch(); }

 private:
  struct Taken {
    int64_t stamp_ns = 0;
    Moment came;
  };
  Verdict Compare(int64_t stamp_ns, Moment came) const;

  std::optional<Taken> newest_;
  // Of those that were left out since one was taken: how many in a row grew, and the last one.
  int astray_ = 0;
  int64_t last_astray_ns_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_STAMP_WATCH_H_
