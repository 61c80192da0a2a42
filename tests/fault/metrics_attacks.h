// Does what a hostile client does to a program's metrics port.
#ifndef CORBSLAM_TESTS_FAULT_METRICS_ATTACKS_H_
#define CORBSLAM_TESTS_FAULT_METRICS_ATTACKS_H_

#include <cstdint>
#include <map>
#include <random>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam::tests {

// Each attack ends by itself. Not thread-safe.
class MetricsAttacker {
 public:
  // Says how many ended with this status, "closed" without an answer, or "open"; "scraped" counts
  // good scrapes that were tried after the attack.
  using Ends = std::map<std::string, int>;

  // `address` is "IP:PORT".
  MetricsAttacker(std::string address, uint64_t seed)
      : address_(std::move(address)), random_(seed) {}

  // Asks for every method on every path, with headers that ask for something else or are too long.
  Ends AskForEverything();
  // Sends requests with bytes changed, cut or made up.
  Ends SendMutatedRequests(int requests);
  // Holds connections that say nothing, or their request byte by byte, all at once.
  Ends HoldConnections(int connections, absl::Duration patience);
  // Opens and closes connections, one after the other.
  Ends OpenAndClose(int connections);
  // Asks for scrapes all at once, and reads no answer.
  Ends ScrapeWithoutReading(int connections, absl::Duration patience);

 private:
  // Asks, and counts how that ended.
  void Count(absl::string_view request, Ends& ends);
  // Adds one scrape as Prometheus makes it.
  Ends AndStillScraped(Ends ends);
  std::string Mutate(std::string request);

  const std::string address_;
  std::mt19937_64 random_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_METRICS_ATTACKS_H_
