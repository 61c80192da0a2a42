#include "services/runtime/connection_book.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace corbslam::services {

std::string HostOfIp(absl::string_view ip) {
  in6_addr address;
  const std::string plain(ip.substr(0, ip.find('%')));
  if (inet_pton(AF_INET6, plain.c_str(), &address) != 1) return std::string(ip);
  char text[INET6_ADDRSTRLEN] = "";
  if (IN6_IS_ADDR_V4MAPPED(&address)) {
    return inet_ntop(AF_INET, &address.s6_addr[12], text, sizeof(text));
  }
  std::fill(address.s6_addr + 8, address.s6_addr + 16, uint8_t{0});
  return absl::StrCat(inet_ntop(AF_INET6, &address, text, sizeof(text)), "/64");
}

ConnectionBook::Verdict ConnectionBook::Enter(Id id, const std::string& name,
                                              const ConnectionLimits& limits) {
  Leave(id);
  Verdict verdict;
  Host* host = &hosts_[name];
  Host* full = host->connections >= limits.of_host ? host : nullptr;
  if (full == nullptr && connections_.size() >= limits.all) full = HostWithMostIdle();
  const bool is_full = full != nullptr || connections_.size() >= limits.all;
  if (is_full && (full == nullptr || full->idle.empty())) {
    if (host->connections == 0) hosts_.erase(name);
    return verdict;
  }
  if (full != nullptr) verdict.makes_room = Forget(*full);
  Connection& connection = connections_[id];
  connection.host = name;
  ++hosts_[name].connections;
  Put(id, connection, Rank::kSilent);
  verdict.taken = true;
  return verdict;
}

void ConnectionBook::Leave(Id id) {
  const auto found = connections_.find(id);
  if (found == connections_.end()) return;
  const auto host = hosts_.find(found->second.host);
  host->second.idle.erase({found->second.place, id});
  if (--host->second.connections == 0) hosts_.erase(host);
  if (found->second.uses > 0) --busy_;
  connections_.erase(found);
}

void ConnectionBook::Speak(Id id) {
  const auto found = connections_.find(id);
  if (found == connections_.end()) return;
  Connection& connection = found->second;
  if (connection.uses > 0 || connection.place.first != Rank::kSilent) return;
  hosts_[connection.host].idle.erase({connection.place, id});
  Put(id, connection, Rank::kSpoke);
}

void ConnectionBook::Begin(Id id) {
  const auto found = connections_.find(id);
  if (found == connections_.end()) return;
  Connection& connection = found->second;
  if (connection.uses++ > 0) return;
  ++busy_;
  hosts_[connection.host].idle.erase({connection.place, id});
}

void ConnectionBook::End(Id id) {
  const auto found = connections_.find(id);
  if (found == connections_.end() || found->second.uses == 0) return;
  Connection& connection = found->second;
  if (--connection.uses > 0) return;
  --busy_;
  Put(id, connection, Rank::kWasBusy);
}

void ConnectionBook::Put(Id id, Connection& connection, Rank rank) {
  connection.place = {rank, ++clock_};
  hosts_[connection.host].idle.insert({connection.place, id});
}

std::optional<ConnectionBook::Id> ConnectionBook::TakeIdlest() {
  Host* const host = HostWithMostIdle();
  if (host == nullptr) return std::nullopt;
  return Forget(*host);
}

ConnectionBook::Host* ConnectionBook::HostWithMostIdle() {
  Host* found = nullptr;
  for (auto& [name, host] : hosts_) {
    if (host.idle.empty()) continue;
    if (found == nullptr || host.idle.size() > found->idle.size()) found = &host;
  }
  return found;
}

ConnectionBook::Id ConnectionBook::Forget(Host& host) {
  const Id id = host.idle.begin()->second;
  Leave(id);
  return id;
}

}  // namespace corbslam::services
