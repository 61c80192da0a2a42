// Checks the way to a server: its address, a proxy, its name, and whether somebody listens.
#include <sys/socket.h>

#include <array>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/client/reachability/cause.h"
#include "services/client/reachability/host_lookup.h"
#include "services/client/reachability/proxy.h"
#include "services/client/reachability/tcp_probe.h"
#include "services/runtime/address.h"

namespace corbslam::services {
namespace {

bool IsOwnMachine(absl::string_view host) {
  return host == "localhost" || host == "::1" || absl::StartsWith(host, "127.");
}

bool IsEveryAddress(absl::string_view host) { return host == "0.0.0.0" || host == "::"; }

// Returns the first line of what a proxy answers to CONNECT; empty if it answers nothing.
std::string AskProxy(const Connection& proxy, const HostPort& server, absl::Duration patience) {
  proxy.MakeBlocking(patience);
  const std::string host = ToString(server);
  const std::string request =
      absl::StrCat("CONNECT ", host, " HTTP/1.1\r\nHost: ", host, "\r\n\r\n");
  if (send(proxy.socket(), request.data(), request.size(), MSG_NOSIGNAL) < 0) return "";
  std::array<char, 256> answer;
  const ssize_t size = recv(proxy.socket(), answer.data(), answer.size(), 0);
  if (size <= 0) return "";
  const absl::string_view text(answer.data(), static_cast<size_t>(size));
  return std::string(text.substr(0, text.find_first_of("\r\n")));
}

// Returns nullopt if the proxy leads to the server.
std::optional<Cause> FindCauseOfProxy(const Proxy& proxy, const HostPort& server,
                                      absl::Duration patience) {
  const std::string is_set =
      absl::StrCat(proxy.variable, " is set, so that gRPC goes through ", proxy.url);
  const std::string advice = absl::StrCat("if no proxy is wanted, unset ", proxy.variable,
                                          " or add ", server.host, " to no_proxy");
  if (!proxy.address.has_value()) return Cause{is_set + ", which is no HOST:PORT", advice};
  const absl::StatusOr<Connection> connection = Connect(*proxy.address, patience);
  if (!connection.ok()) {
    return Cause{absl::StrCat(is_set, ", which is not reached: ", connection.status().message()),
                 advice};
  }
  const std::string answer = AskProxy(*connection, server, patience);
  if (absl::StartsWith(answer, "HTTP/1.") && absl::StrContains(answer, " 200")) return std::nullopt;
  if (answer.empty()) {
    return Cause{is_set + ", which does not answer", advice, /*is_certain=*/false};
  }
  return Cause{absl::StrCat(is_set, ", which answers \"", answer, "\""), advice};
}

Cause CauseOfLookup(const absl::Status& status, const HostPort& address, absl::Duration patience) {
  if (absl::IsNotFound(status)) {
    std::string advice =
        "is it spelled right? DNS or /etc/hosts must know it; or give its IP address";
    if (absl::EndsWith(address.host, ".local")) {
      advice += " (names in .local need libnss-mdns, and GRPC_DNS_RESOLVER=native)";
    }
    return {absl::StrCat("no host is called ", address.host), advice};
  }
  if (absl::IsDeadlineExceeded(status)) {
    return {absl::StrCat("looking up ", address.host, " takes longer than ",
                         absl::FormatDuration(patience)),
            "DNS is slow or does not answer (/etc/resolv.conf); or give the IP address",
            /*is_certain=*/false};
  }
  return {std::string(status.message()),
          "DNS does not answer (/etc/resolv.conf); or give the IP "
          "address"};
}

Cause CauseOfConnection(const ServerTarget& target, const absl::Status& status,
                        const HostPort& address) {
  if (absl::IsDeadlineExceeded(status)) {
    return {std::string(status.message()),
            "is this the right address, is the machine on, and does no firewall drop the port?",
            /*is_certain=*/false};
  }
  const std::string name = NameOfService(target.service);
  if (!absl::StrContains(status.message(), "refused")) {
    return {std::string(status.message()), "is this machine in the network of that one?"};
  }
  std::string advice =
      absl::StrCat("start the ", name, ", or give the port that it says it is \"listening on\"");
  if (IsEveryAddress(address.host)) {
    absl::StrAppend(&advice, "; ", address.host,
                    " is for --listen: from another machine give the server's own address");
  } else if (!IsOwnMachine(address.host)) {
    absl::StrAppend(&advice, "; without --listen it is reached from its own machine only");
  }
  return {std::string(status.message()), advice};
}

}  // namespace

std::optional<Cause> FindCauseOfWay(const ServerTarget& target, absl::Duration patience) {
  const absl::StatusOr<HostPort> address = ParseServerAddress(target.address);
  if (!address.ok()) {
    return Cause{std::string(address.status().message()), "", /*is_certain=*/true,
                 /*is_bad_address=*/true};
  }
  const std::optional<Proxy> proxy = FindProxy(address->host);
  if (proxy.has_value()) return FindCauseOfProxy(*proxy, *address, patience);
  const absl::Status found = LookUpHost(*address, patience).status();
  if (!found.ok()) return CauseOfLookup(found, *address, patience);
  const absl::Status reached = ProbeTcp(*address, patience);
  if (reached.ok()) return std::nullopt;
  return CauseOfConnection(target, reached, *address);
}

}  // namespace corbslam::services
