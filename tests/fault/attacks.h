// What a hostile client does to a map store.
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

namespace corbslam {

// Not thread-safe. Attacks a store that serves without TLS; each attack ends by itself.
class Attacker {
 public:
  // How calls ended, by their code's name; "open" for those that did not.
  using Ends = std::map<std::string, int>;

  // `victim` is a local map that a robot of `mission` uploads now; `uploads` are good batches.
  Attacker(std::string address, std::string mission, LocalMapId victim,
           const RecordedUploads* uploads, uint64_t seed);

  // Messages of a good session with bytes changed, cut, doubled or made up; so many in all.
  Ends SendMutatedMessages(int messages);
  // Batches that the rules forbid: another's local map, numbers that are missing or were
  // used, values that are none. Returns the ends by attack.
  std::map<std::string, std::string> SendForbiddenBatches();
  // Raw HTTP/2: a message that claims to have 2 GB, and no more comes. Whether the store ends it.
  bool ClaimTwoGigabytes(absl::Duration patience);
  // Opens streams that say nothing.
  Ends OpenSilentStreams(int streams, absl::Duration patience);

 private:
  std::string OpenMessage(const std::string& mission, const std::string& agent) const;
  std::string BatchMessage(const MapUpdateBatch& batch) const;
  std::string Mutate(std::string bytes);
  std::string TryBatch(const std::string& mission, const std::string& agent,
                       const std::vector<MapUpdateBatch>& batches) const;

  const std::string address_;
  const std::string mission_;
  const LocalMapId victim_;
  const RecordedUploads& uploads_;
  std::mt19937_64 random_;
};

}  // namespace corbslam

#endif  // CORBSLAM_TESTS_FAULT_ATTACKS_H_
