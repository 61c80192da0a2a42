// Decides which connections a server keeps: how many in all, how many of one host, and who makes
// room for whom.
#ifndef CORBSLAM_SERVICES_RUNTIME_CONNECTION_BOOK_H_
#define CORBSLAM_SERVICES_RUNTIME_CONNECTION_BOOK_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"

namespace corbslam::services {

struct ConnectionLimits {
  size_t all = 2048;
  size_t of_host = 512;
};

// What became of the connections of one port.
struct ConnectionCounts {
  size_t open = 0;
  size_t busy = 0;
  ConnectionLimits limits;
  uint64_t refused = 0;          // All others were busy, or the process had no file left.
  uint64_t closed_for_room = 0;  // They did nothing, and made room for newer ones.
};

// Returns what counts as one host: an IPv4 address, or the 64 bits of an IPv6 address that one
// network has ("2001:db8:0:7::/64"). `ip` is without port and brackets; what is no IP address
// stands for itself.
std::string HostOfIp(absl::string_view ip);

// Counts connections. One that is new, or idle, makes room for a newer one; one that is busy stays.
// Not thread-safe.
class ConnectionBook {
 public:
  using Id = uint64_t;

  // What becomes of a connection that has come.
  struct Verdict {
    bool taken = false;                 // False: all others of its host, or of all, are busy.
    std::optional<Id> makes_room = {};  // This one is to be closed; it counts no more.
  };

  // Takes a connection in. If there are as many as `limits` say, the one that has done nothing for
  // the longest time goes: of the same host where that has its fill, else of the host with most
  // connections that are not busy. Those that never were busy go before those that were.
  Verdict Enter(Id id, const std::string& host, const ConnectionLimits& limits);
  // A connection has ended; unknown ids are passed over, here and below.
  void Leave(Id id);
  // Something has come on it.
  void Speak(Id id);
  // Something is under way on it, from Begin to End; that may be several things at once.
  void Begin(Id id);
  void End(Id id);
  // Returns the connection that would make room next, and forgets it; nullopt: all are busy.
  std::optional<Id> TakeIdlest();

  bool contains(Id id) const { return connections_.contains(id); }
  size_t size() const { return connections_.size(); }
  size_t busy() const { return busy_; }

 private:
  enum class Rank : uint8_t { kSilent, kSpoke, kWasBusy };
  // The least one goes first: what came of it so far, then since when it does nothing.
  using Place = std::pair<Rank, uint64_t>;
  struct Connection {
    std::string host;
    Place place;
    size_t uses = 0;
  };
  struct Host {
    size_t connections = 0;
    std::set<std::pair<Place, Id>> idle = {};
  };

  // Gives an idle connection its place among those of its host.
  void Put(Id id, Connection& connection, Rank rank);
  Id Forget(Host& host);
  Host* HostWithMostIdle();

  uint64_t clock_ = 0;
  size_t busy_ = 0;
  std::map<Id, Connection> connections_;
  std::map<std::string, Host> hosts_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_CONNECTION_BOOK_H_
