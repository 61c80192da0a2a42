// Does what a hostile client does to a map store.
#ifndef CORBSLAM_TESTS_FAULT_ATTACKS_H_
#define CORBSLAM_TESTS_FAULT_ATTACKS_H_

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "slam/exchange/map_update.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

// Attacks a store that serves without TLS; each attack ends by itself. Not thread-safe.
class Attacker {
 public:
  // Says how calls ended, by their code's name; "open" for those that did not.
  using Ends = std::map<std::string, int>;

  // `victim` is a local map that a robot of `mission` uploads now; `uploads` are good batches.
  Attacker(std::string address, std::string mission, LocalMapId victim,
           const RecordedUploads* uploads, uint64_t seed);

  // Sends messages of a good session with bytes changed, cut, doubled or made up; `messages` in
  // all.
  Ends SendMutatedMessages(int messages);
  // Sends batches that the rules forbid: another's local map, numbers that are missing, values that
  // are none. Returns the ends by attack.
  std::map<std::string, std::string> SendForbiddenBatches();
  // Sends a good batch of its own, and its number again and again with other batches. Returns how
  // many were acknowledged, as "OK".
  Ends ReplayANumber(int times);
  // Sends a message in raw HTTP/2 that claims to have 2 GB, and no more comes. Ends are "ended" or
  // "open".
  Ends ClaimTwoGigabytes(absl::Duration patience);
  // Sends a small message in the same way, byte by byte, that never ends.
  Ends Dribble(absl::Duration patience);
  // Opens streams of this method that say nothing, over as many connections as they need.
  Ends OpenSilentStreams(const std::string& method, int streams, absl::Duration patience);
  // Makes look-ups that are all under way at once, over as many connections as they need.
  Ends FloodWithLookups(int calls, absl::Duration patience);

  // The attacker sends what is its own to this mission.
  static constexpr char kOwnMission[] = "evil";

 private:
  std::string OpenMessage(const std::string& mission, const std::string& agent) const;
  std::string BatchMessage(const MapUpdateBatch& batch) const;
  std::string Mutate(std::string bytes);
  Ends SendRawMessage(uint32_t claimed_bytes, bool dribbles, absl::Duration patience);
  // Makes calls that are all under way at once, each with this message (empty: without any).
  Ends MakeCalls(const std::string& method, const std::string& message, int calls,
                 absl::Duration patience) const;
  std::string TryBatch(const std::string& mission, const std::string& agent,
                       const std::vector<MapUpdateBatch>& batches) const;

  const std::string address_;
  const std::string mission_;
  const LocalMapId victim_;
  const RecordedUploads& uploads_;
  std::mt19937_64 random_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_ATTACKS_H_
