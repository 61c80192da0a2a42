// What a hostile client does to a program's metrics port.
#ifndef CORBSLAM_TESTS_FAULT_METRICS_ATTACKS_H_
#define CORBSLAM_TESTS_FAULT_METRICS_ATTACKS_H_

#include <cstdint>
#include <map>
#include <random>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam {

// Not thread-safe. Each attack ends by itself.
class MetricsAttacker {
 public:
  // How many ended with this status, "closed" without an answer, or "open"; "scraped" counts good
  // scrapes that were tried after the attack.
  using Ends = std::map<std::string, int>;

  // `address`: "IP:PORT".
  MetricsAttacker(std::string address, uint64_t seed)
      : address_(std::move(address)), random_(seed) {}

  // Every method on every path, with headers that ask for something else or are too long.
  Ends AskForEverything();
  // Requests with bytes changed, cut or made up.
  Ends SendMutatedRequests(int requests);
  // Connections that say nothing, or their request byte by byte, all at once.
  Ends HoldConnections(int connections, absl::Duration patience);
  // Connections that are opened and closed, one after the other.
  Ends OpenAndClose(int connections);
  // Scrapes that are all asked for at once, and whose answers nobody reads.
  Ends ScrapeWithoutReading(int connections, absl::Duration patience);

 private:
  // Asks, and counts how that ended.
  void Count(absl::string_view request, Ends& ends);
  // With one scrape as Prometheus makes it.
  Ends AndStillScraped(Ends ends);
  std::string Mutate(std::string request);

  const std::string address_;
  std::mt19937_64 random_;
};

}  // namespace corbslam

#endif  // CORBSLAM_TESTS_FAULT_METRICS_ATTACKS_H_
