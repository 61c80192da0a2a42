#include "map_store/postgres/postgres_options.h"

#include <libpq-fe.h>

#include <algorithm>
#include <memory>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace corbslam::map_store {
namespace {

struct FreesWords {
  void operator()(PQconninfoOption* words) const { PQconninfoFree(words); }
};

std::string ValueOf(const ConnectionWords& words, const std::string& key) {
  const auto it = words.find(key);
  return it == words.end() ? std::string() : it->second;
}

// Sockets in a folder and the machine's own addresses need no encryption.
bool IsLocal(const std::string& hosts) {
  const std::vector<std::string> names = absl::StrSplit(hosts, ',');
  return std::all_of(names.begin(), names.end(), [](const std::string& host) {
    return host.empty() || host.front() == '/' || host.front() == '@' || host == "localhost" ||
           host == "127.0.0.1" || host == "::1";
  });
}

std::string HostsOf(const ConnectionWords& words) {
  const std::string hosts = ValueOf(words, "host");
  return hosts.empty() ? ValueOf(words, "hostaddr") : hosts;
}

}  // namespace

absl::StatusOr<ConnectionWords> ReadConnectionWords(const PostgresJournalOptions& options) {
  char* text = nullptr;
  const std::unique_ptr<PQconninfoOption, FreesWords> parsed(
      PQconninfoParse(options.uri.c_str(), &text));
  const std::unique_ptr<char, decltype(&PQfreemem)> error(text, &PQfreemem);
  if (parsed == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("libpq can't read the URI of the journal: ",
                     error != nullptr ? error.get() : "there is no memory",
                     "; it is to be like postgresql://corbslam@db1:5432/corbslam"));
  }
  ConnectionWords words;
  for (const PQconninfoOption* word = parsed.get(); word->keyword != nullptr; ++word) {
    if (word->val != nullptr && *word->val != '\0') words[word->keyword] = word->val;
  }
  if (words.contains("password")) {
    return absl::InvalidArgumentError(
        "the URI of the journal has a password, which the list of processes shows: use a file with "
        "--journal-password-file, the URI's passfile, or a certificate");
  }
  words.emplace("target_session_attrs", "read-write");
  words.emplace("connect_timeout",
                absl::StrCat(std::max<int64_t>(2, absl::ToInt64Seconds(options.connect_timeout))));
  words.emplace("keepalives_idle", "10");
  words.emplace("keepalives_interval", "5");
  words.emplace("keepalives_count", "3");
  words.emplace("fallback_application_name", "corbslam map_store");
  if (!IsLocal(HostsOf(words))) words.emplace("sslmode", "verify-full");
  return words;
}

std::string NameOfDatabase(const ConnectionWords& words) {
  const std::string port = ValueOf(words, "port");
  return absl::StrCat("postgres ", HostsOf(words), port.empty() ? "" : ":", port, "/",
                      ValueOf(words, "dbname"));
}

std::string WarnOfConnection(const ConnectionWords& words) {
  const std::string mode = ValueOf(words, "sslmode");
  if (IsLocal(HostsOf(words)) || mode == "verify-full") return "";
  return absl::StrCat("sslmode=", mode, " of the journal's URI ",
                      mode == "verify-ca" ? "takes any server of the authority for the right one"
                                          : "lets others read and change what is written",
                      ": verify-full with sslrootcert does not");
}

}  // namespace corbslam::map_store
