// Says where other stores of one database send robots that want a mission of this one's.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_ADDRESS_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_ADDRESS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/records/mission_leases.h"

namespace corbslam::services {

// Returns how this machine is called among others.
std::string NameOfMachine();
// Returns whether only programs of this machine reach the address: it is a loopback one.
bool IsReachedFromHereAlone(const std::string& address);

// Returns INVALID_ARGUMENT, naming the flag, if others can't connect to what --advertise says, or
// nobody needs it, as missions are not shared. Empty: it was not given.
absl::Status CheckAdvertise(const std::string& advertise, bool is_shared);

// Returns HOST:PORT for others: what --advertise says, else what the store serves, with the
// machine's name in the place of "all addresses".
absl::StatusOr<std::string> AddressForOthers(const std::string& advertise,
                                             const std::string& served, const std::string& machine);
// Returns FAILED_PRECONDITION if only programs of this machine reach the address, and a store of
// another machine has missions of the same database.
absl::Status CheckReachedByAll(const std::string& address, const std::string& machine,
                               const std::vector<map_store::DirectoryStore>& stores);
// Does both, and tells the directory. Returns the store's name in it, which is its address, and
// another one on each machine if only programs of that reach it.
absl::StatusOr<std::string> AnnounceStore(const std::string& advertise, const std::string& served,
                                          map_store::MissionLeases& leases);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_ADDRESS_H_
