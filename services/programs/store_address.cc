#include "services/programs/store_address.h"

#include <arpa/inet.h>
#include <unistd.h>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/runtime/address.h"
#include "slam/util/program_version.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::DirectoryStore;

namespace {

bool IsOfAllAddresses(const std::string& host) {
  in_addr v4 = {};
  in6_addr v6 = {};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return v4.s_addr == INADDR_ANY;
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_UNSPECIFIED(&v6);
  return host.empty();
}

bool IsOfThisMachineAlone(const std::string& host) {
  in6_addr v6 = {};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return host == "localhost" || absl::StartsWith(host, "127.");
}

}  // namespace

std::string NameOfMachine() {
  char name[256] = "";
  return gethostname(name, sizeof(name) - 1) == 0 && name[0] != '\0' ? name : "localhost";
}

bool IsReachedFromHereAlone(const std::string& address) {
  const absl::StatusOr<HostPort> parsed = ParseServerAddress(address);
  return parsed.ok() && IsOfThisMachineAlone(parsed->host);
}

absl::Status CheckAdvertise(const std::string& advertise, bool is_shared) {
  if (advertise.empty()) return absl::OkStatus();
  if (!is_shared) {
    return absl::InvalidArgumentError(
        "--advertise is of no use without --journal and --journal-lease: no other store sends "
        "robots here");
  }
  const absl::StatusOr<HostPort> parsed = ParseServerAddress(advertise);
  if (!parsed.ok()) {
    return absl::Status(parsed.status().code(),
                        absl::StrCat("--advertise: ", parsed.status().message()));
  }
  if (!IsOfAllAddresses(parsed->host)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("--advertise is ", advertise,
                   ", which nobody can connect to: give this machine's name or address"));
}

absl::StatusOr<std::string> AddressForOthers(const std::string& advertise,
                                             const std::string& served,
                                             const std::string& machine) {
  if (!advertise.empty()) return advertise;
  ASSIGN_OR_RETURN(HostPort address, ParseListenAddress(served));
  if (IsOfAllAddresses(address.host)) address.host = machine;
  return ToString(address);
}

absl::Status CheckReachedByAll(const std::string& address, const std::string& machine,
                               const std::vector<DirectoryStore>& stores) {
  ASSIGN_OR_RETURN(const HostPort parsed, ParseServerAddress(address));
  if (!IsOfThisMachineAlone(parsed.host)) return absl::OkStatus();
  for (const DirectoryStore& store : stores) {
    const bool is_alive = store.lease_left > absl::ZeroDuration();
    if (store.is_own || !is_alive || store.machine == machine) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "robots would be sent to ", address, ", which only programs of ", machine,
        " reach, and a store of ", store.machine, " (", store.address,
        ") shares the database: say with --listen and --advertise where all reach this one"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> AnnounceStore(const std::string& advertise, const std::string& served,
                                          map_store::MissionLeases& leases) {
  DirectoryStore self;
  self.machine = NameOfMachine();
  self.version = CorbslamVersion();
  ASSIGN_OR_RETURN(self.address, AddressForOthers(advertise, served, self.machine));
  ASSIGN_OR_RETURN(const std::vector<DirectoryStore> stores, leases.ListStores());
  RETURN_IF_ERROR(CheckReachedByAll(self.address, self.machine, stores));
  ASSIGN_OR_RETURN(const HostPort parsed, ParseServerAddress(self.address));
  self.name = IsOfThisMachineAlone(parsed.host) ? absl::StrCat(self.machine, "/", self.address)
                                                : self.address;
  RETURN_IF_ERROR(leases.Announce(self));
  return self.name;
}

}  // namespace corbslam::services
