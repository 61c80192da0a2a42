#include "services/runtime/port_holder.h"

#include <netinet/in.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

// An address as /proc/net/tcp writes it: pieces of 32 bits in the processor's own order.
struct LocalAddress {
  std::string ip;
  std::string port;
};

template <typename T>
std::string HexOf(const T& bytes) {
  std::string fields;
  for (size_t i = 0; i < sizeof(bytes); i += sizeof(uint32_t)) {
    uint32_t word = 0;
    std::memcpy(&word, reinterpret_cast<const char*>(&bytes) + i, sizeof(word));
    absl::StrAppendFormat(&fields, "%08X", word);
  }
  return fields;
}

// Returns the IPv4 part of a mapped address: gRPC's servers listen on IPv4's addresses by sockets
// of IPv6 (::ffff:127.0.0.1).
std::string WithoutMapping(const std::string& ip) {
  const std::string prefix = absl::StrCat("0000000000000000", HexOf(htonl(0xffff)));
  return absl::StartsWith(ip, prefix) ? ip.substr(prefix.size()) : ip;
}

LocalAddress AddressOf(const sockaddr_storage& address) {
  if (address.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
    return {WithoutMapping(HexOf(v6.sin6_addr)), absl::StrFormat("%04X", ntohs(v6.sin6_port))};
  }
  const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
  return {HexOf(v4.sin_addr), absl::StrFormat("%04X", ntohs(v4.sin_port))};
}

bool IsAny(const std::string& ip) { return ip.find_first_not_of('0') == std::string::npos; }

// Returns true if two sockets exclude each other: one of all addresses keeps out each single one,
// and the other way round.
bool ExcludeEachOther(const LocalAddress& a, const LocalAddress& b) {
  return a.port == b.port && (a.ip == b.ip || IsAny(a.ip) || IsAny(b.ip));
}

// Inodes of the sockets of this network namespace that keep others from an address.
struct Holders {
  std::set<std::string> listening;
  std::set<std::string> connected;
};

void ReadHolders(const char* table, const LocalAddress& wanted, Holders& holders) {
  constexpr size_t kAddress = 1, kState = 3, kInode = 9;
  std::ifstream sockets(table);
  std::string line;
  std::getline(sockets, line);  // The first line has the headings.
  while (std::getline(sockets, line)) {
    const std::vector<std::string> fields = absl::StrSplit(line, ' ', absl::SkipEmpty());
    if (fields.size() <= kInode || fields[kInode] == "0") continue;
    const std::vector<std::string> local = absl::StrSplit(fields[kAddress], ':');
    if (local.size() != 2 || !ExcludeEachOther({WithoutMapping(local[0]), local[1]}, wanted)) {
      continue;
    }
    (fields[kState] == "0A" ? holders.listening : holders.connected).insert(fields[kInode]);
  }
}

bool HasSocket(const fs::path& process, const std::set<std::string>& inodes) {
  std::error_code error;
  for (fs::directory_iterator it(process / "fd", error), end; !error && it != end;
       it.increment(error)) {
    std::error_code unreadable;
    const std::string target = fs::read_symlink(it->path(), unreadable).string();
    const bool is_one = std::any_of(inodes.begin(), inodes.end(), [&target](const auto& inode) {
      return target == absl::StrCat("socket:[", inode, "]");
    });
    if (is_one) return true;
  }
  return false;
}

std::optional<pid_t> FindProcessWith(const std::set<std::string>& inodes) {
  if (inodes.empty()) return std::nullopt;
  std::error_code error;
  for (fs::directory_iterator it("/proc", error), end; !error && it != end; it.increment(error)) {
    pid_t pid = 0;
    if (!absl::SimpleAtoi(it->path().filename().string(), &pid)) continue;
    if (HasSocket(it->path(), inodes)) return pid;
  }
  return std::nullopt;
}

}  // namespace

std::optional<pid_t> FindPortHolder(const sockaddr_storage& address) {
  const LocalAddress wanted = AddressOf(address);
  Holders holders;
  for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
    ReadHolders(table, wanted, holders);
  }
  const std::optional<pid_t> listening = FindProcessWith(holders.listening);
  return listening.has_value() || !holders.listening.empty() ? listening
                                                             : FindProcessWith(holders.connected);
}

}  // namespace corbslam::services
