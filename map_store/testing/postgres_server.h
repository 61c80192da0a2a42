// A PostgreSQL server of a test's own, which the test may kill. It needs Debian's package
// postgresql-15.
#ifndef CORBSLAM_MAP_STORE_TESTING_POSTGRES_SERVER_H_
#define CORBSLAM_MAP_STORE_TESTING_POSTGRES_SERVER_H_

#include <sys/types.h>

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/postgres/postgres_options.h"

namespace corbslam::testing {

// Not thread-safe but for QueryAll and Ask.
class PostgresServer {
 public:
  // Returns the server of this program, which is started at the first call and ends with it.
  static PostgresServer& Get();
  ~PostgresServer();

  // Makes an empty database with the journal's tables, and returns its name. The role "corbslam"
  // has in it the rights of a map store and no others.
  std::string MakeDatabase();
  // Says how to reach the database as that role: through a socket in a folder, or by TCP.
  std::string Uri(const std::string& database) const;
  std::string TcpUri(const std::string& database, int port) const;
  int port() const { return port_; }
  const std::string& folder() const { return folder_; }

  // Runs statements in one session as the administrator, and returns the last one's first column.
  absl::StatusOr<std::vector<std::string>> QueryAll(
      const std::string& database, const std::vector<std::string>& statements) const;
  // The same with one statement, of which an error is a failed test; returns the first value.
  std::string Ask(const std::string& database, const std::string& sql) const;

  void Start();
  // Ends the server with SIGKILL.
  void Kill();

 private:
  PostgresServer();
  // Starts a program of the server's as a user that it allows.
  pid_t Launch(const std::vector<std::string>& command) const;

  std::string folder_;
  int port_ = 0;
  pid_t pid_ = 0;
  int databases_ = 0;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_POSTGRES_SERVER_H_
