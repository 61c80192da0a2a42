#include "map_store/testing/postgres_server.h"

#include <fcntl.h>
#include <glob.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <libpq-fe.h>
#include <netinet/in.h>
#include <pwd.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "map_store/postgres/schema.h"

namespace corbslam::testing {
namespace {

constexpr char kAdministrator[] = "postgres";
constexpr absl::Duration kPatience = absl::Seconds(60);

// Returns the path of a program of the newest server that is installed.
std::string ServerProgram(const std::string& name) {
  glob_t found;
  std::string path = name;
  if (glob(("/usr/lib/postgresql/*/bin/" + name).c_str(), 0, nullptr, &found) == 0) {
    path = found.gl_pathv[found.gl_pathc - 1];
    globfree(&found);
  }
  return path;
}

int FreePort() {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  EXPECT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(fd);
  return ntohs(address.sin_port);
}

void BecomeServerUser() {
  const passwd* user = geteuid() == 0 ? getpwnam("postgres") : nullptr;
  if (user == nullptr) return;
  if (initgroups(user->pw_name, user->pw_gid) != 0 || setgid(user->pw_gid) != 0 ||
      setuid(user->pw_uid) != 0) {
    _exit(126);
  }
}

bool IsInstalled() {
  const char* folders = std::getenv("PATH");
  if (ServerProgram("initdb") != "initdb") return true;
  for (const absl::string_view folder : absl::StrSplit(folders == nullptr ? "" : folders, ':')) {
    if (access(absl::StrCat(folder, "/initdb").c_str(), X_OK) == 0) return true;
  }
  return false;
}

// Skips the program's tests where there is no server; in continuous integration they fail.
class NeedsServer : public ::testing::Environment {
 public:
  void SetUp() override {
    if (IsInstalled() || std::getenv("CI") != nullptr) return;
    GTEST_SKIP() << "PostgreSQL's server is not installed (Debian's package postgresql-15)";
  }
};
const ::testing::Environment* const kNeedsServer =
    ::testing::AddGlobalTestEnvironment(new NeedsServer);

}  // namespace

PostgresServer& PostgresServer::Get() {
  static PostgresServer server;
  return server;
}

PostgresServer::PostgresServer() {
  // The folder of the test's own may be closed to the server's user.
  std::string made = "/tmp/corbslam_postgres_XXXXXX";
  EXPECT_NE(mkdtemp(made.data()), nullptr);
  folder_ = made;
  if (const passwd* user = geteuid() == 0 ? getpwnam("postgres") : nullptr; user != nullptr) {
    EXPECT_EQ(chown(folder_.c_str(), user->pw_uid, user->pw_gid), 0);
  }
  port_ = FreePort();
  const pid_t initdb =
      Launch({ServerProgram("initdb"), "-D", folder_ + "/data", "-U", kAdministrator, "-A", "trust",
              "-E", "UTF8", "--locale=C", "--no-sync"});
  int status = 1;
  waitpid(initdb, &status, 0);
  EXPECT_EQ(status, 0) << "initdb failed; the tests need Debian's package postgresql-15";
  Start();
  Ask("postgres", "CREATE ROLE corbslam LOGIN");
}

PostgresServer::~PostgresServer() {
  Kill();
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
}

pid_t PostgresServer::Launch(const std::vector<std::string>& command) const {
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  const std::string log = folder_ + "/log";
  const pid_t child = fork();
  if (child != 0) return child;
  BecomeServerUser();
  const int fd = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  dup2(fd, 1);
  dup2(fd, 2);
  if (chdir("/") == 0) execvp(words[0], words.data());
  _exit(127);
}

void PostgresServer::Start() {
  const absl::Time until = absl::Now() + kPatience;
  const std::string where = absl::StrCat("host=", folder_, " port=", port_, " dbname=postgres");
  while (absl::Now() < until) {
    pid_ = Launch({ServerProgram("postgres"), "-D", folder_ + "/data", "-k", folder_, "-p",
                   absl::StrCat(port_), "-c", "listen_addresses=127.0.0.1", "-c", "fsync=off", "-c",
                   "shared_buffers=32MB", "-c", "max_connections=50"});
    // After a kill the first attempts may find that the old server's processes are not gone yet.
    while (waitpid(pid_, nullptr, WNOHANG) == 0 && absl::Now() < until) {
      if (PQping(where.c_str()) == PQPING_OK) return;
      absl::SleepFor(absl::Milliseconds(20));
    }
    absl::SleepFor(absl::Milliseconds(100));
  }
  pid_ = 0;
  std::ifstream log(folder_ + "/log");
  ADD_FAILURE() << "the PostgreSQL server does not start: "
                << std::string(std::istreambuf_iterator<char>(log), {});
}

void PostgresServer::Kill() {
  if (pid_ <= 0) return;
  // Its processes for connections would answer for a moment longer.
  std::ifstream children(absl::StrCat("/proc/", pid_, "/task/", pid_, "/children"));
  kill(pid_, SIGSTOP);
  for (pid_t child = 0; children >> child;) kill(child, SIGKILL);
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = 0;
}

std::string PostgresServer::MakeDatabase() {
  const std::string database = absl::StrCat("t", ++databases_);
  Ask("postgres", "CREATE DATABASE " + database);
  const auto schema = map_store::MakeSchemaSql("corbslam");
  EXPECT_TRUE(schema.ok()) << schema.status();
  for (int i = 0; i < 2; ++i) Ask(database, *schema);  // It may be run again.
  return database;
}

std::string PostgresServer::Uri(const std::string& database) const {
  return absl::StrCat("host=", folder_, " port=", port_, " dbname=", database, " user=corbslam");
}

std::string PostgresServer::TcpUri(const std::string& database, int port) const {
  return absl::StrCat("postgresql://corbslam@127.0.0.1:", port, "/", database, "?sslmode=disable");
}

absl::StatusOr<std::vector<std::string>> PostgresServer::QueryAll(
    const std::string& database, const std::vector<std::string>& statements) const {
  const std::string where = absl::StrCat("host=", folder_, " port=", port_, " dbname=", database,
                                         " user=", kAdministrator);
  const std::unique_ptr<PGconn, decltype(&PQfinish)> connection(PQconnectdb(where.c_str()),
                                                                &PQfinish);
  PQsetNoticeProcessor(
      connection.get(), [](void*, const char*) {}, nullptr);
  std::vector<std::string> values;
  for (const std::string& sql : statements) {
    const std::unique_ptr<PGresult, decltype(&PQclear)> result(
        PQexec(connection.get(), sql.c_str()), &PQclear);
    const ExecStatusType status = PQresultStatus(result.get());
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) {
      return absl::InternalError(PQerrorMessage(connection.get()));
    }
    values.clear();
    for (int i = 0; i < PQntuples(result.get()); ++i) {
      values.emplace_back(PQgetvalue(result.get(), i, 0));
    }
  }
  return values;
}

std::string PostgresServer::Ask(const std::string& database, const std::string& sql) const {
  const auto values = QueryAll(database, {sql});
  EXPECT_TRUE(values.ok()) << sql << ": " << values.status();
  return values.ok() && !values->empty() ? values->front() : "";
}

}  // namespace corbslam::testing
