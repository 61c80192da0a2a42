#include "services/runtime/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

// Lines that our programs print (services/server/server.h).
constexpr absl::string_view kAnnouncement = "listening on ";
constexpr absl::string_view kFinished = "finished";

double ToSeconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

// Runs in the child, between fork and exec: it calls nothing that is not async-signal-safe.
[[noreturn]] void BecomeProgram(const std::vector<char*>& arguments, int output, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // The parent died before the line above.
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execv(arguments.front(), arguments.data());
  _exit(127);
}

}  // namespace

absl::StatusOr<std::unique_ptr<ChildProcess>> ChildProcess::Start(
    const std::string& name, const std::vector<std::string>& command, const std::string& log_path) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    return absl::UnavailableError(absl::StrCat(name, ": no pipe: ", std::strerror(errno)));
  }
  std::vector<char*> arguments;
  for (const std::string& argument : command) {
    arguments.push_back(const_cast<char*>(argument.c_str()));
  }
  arguments.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) BecomeProgram(arguments, ends[1], parent);
  close(ends[1]);
  if (pid < 0) {
    close(ends[0]);
    return absl::UnavailableError(absl::StrCat(name, ": no process: ", std::strerror(errno)));
  }
  return std::unique_ptr<ChildProcess>(new ChildProcess(name, log_path, pid, ends[0]));
}

ChildProcess::ChildProcess(std::string name, std::string log_path, pid_t pid, int output)
    : name_(std::move(name)), log_path_(std::move(log_path)), pid_(pid) {
  reader_ = StartThread("program output", [this, output] { ReadOutput(output); });
  reaper_ = StartThread("program end", [this] { Reap(); });
}

ChildProcess::~ChildProcess() {
  Stop(absl::ZeroDuration());
  reader_.join();
  reaper_.join();
}

void ChildProcess::ReadOutput(int output) {
  std::ofstream log(log_path_);
  FILE* stream = fdopen(output, "r");
  char* text = nullptr;
  size_t capacity = 0;
  while (getline(&text, &capacity, stream) >= 0) {
    log << text << std::flush;
    NoteLine(absl::StripAsciiWhitespace(text));
  }
  free(text);
  fclose(stream);
  absl::MutexLock lock(&mutex_);
  output_ended_ = true;
}

void ChildProcess::NoteLine(absl::string_view line) {
  absl::MutexLock lock(&mutex_);
  if (line == kFinished) finished_ = true;
  if (absl::ConsumePrefix(&line, kAnnouncement) && !address_.has_value()) {
    address_ = std::string(line);
  }
}

void ChildProcess::Reap() {
  int status = 0;
  rusage usage = {};
  while (wait4(pid_, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  ProcessEnd end;
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  end.peak_rss_mb = static_cast<double>(usage.ru_maxrss) / 1024;
  end.cpu_s = ToSeconds(usage.ru_utime) + ToSeconds(usage.ru_stime);
  absl::MutexLock lock(&mutex_);
  end_ = end;
}

absl::StatusOr<std::string> ChildProcess::WaitForAddress(absl::Duration timeout) {
  {
    absl::MutexLock lock(&mutex_);
    const auto is_known = [this] {
      mutex_.AssertReaderHeld();
      return address_.has_value() || output_ended_;
    };
    if (!mutex_.AwaitWithTimeout(absl::Condition(&is_known), timeout)) {
      return absl::DeadlineExceededError(absl::StrCat(name_, " named no address in time"));
    }
    if (address_.has_value()) return *address_;
  }
  return absl::UnavailableError(absl::StrCat(name_, " ended without an address:\n", LastLines()));
}

bool ChildProcess::WaitUntilFinished(absl::Duration timeout) {
  absl::MutexLock lock(&mutex_);
  const auto is_done = [this] {
    mutex_.AssertReaderHeld();
    return finished_ || (end_.has_value() && output_ended_);
  };
  return mutex_.AwaitWithTimeout(absl::Condition(&is_done), timeout);
}

bool ChildProcess::WaitForEnd(absl::Duration timeout) {
  absl::MutexLock lock(&mutex_);
  const auto has_ended = [this] {
    mutex_.AssertReaderHeld();
    return end_.has_value() && output_ended_;
  };
  return mutex_.AwaitWithTimeout(absl::Condition(&has_ended), timeout);
}

std::optional<ProcessEnd> ChildProcess::end() const {
  absl::MutexLock lock(&mutex_);
  return end_;
}

absl::Status ChildProcess::EndStatus() const {
  const std::optional<ProcessEnd> ended = end();
  if (!ended.has_value()) return absl::FailedPreconditionError(name_ + " still runs");
  if (ended->exit_code == 0) return absl::OkStatus();
  return absl::InternalError(absl::StrCat(name_, " ended with exit code ", ended->exit_code,
                                          "; the end of ", log_path_, ":\n", LastLines()));
}

ProcessEnd ChildProcess::Stop(absl::Duration grace) {
  if (!end().has_value() && grace > absl::ZeroDuration()) {
    kill(pid_, SIGTERM);
    WaitForEnd(grace);
  }
  if (!end().has_value()) kill(pid_, SIGKILL);
  WaitForEnd(absl::InfiniteDuration());
  return end().value_or(ProcessEnd{});
}

std::string ChildProcess::LastLines() const {
  constexpr size_t kLines = 15;
  std::ifstream log(log_path_);
  std::deque<std::string> lines;
  for (std::string line; std::getline(log, line);) {
    lines.push_back(std::move(line));
    if (lines.size() > kLines) lines.pop_front();
  }
  return absl::StrJoin(lines, "\n");
}

absl::StatusOr<std::string> FindProgramBeside(const std::string& name) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path path = self.parent_path() / name;
  if (!error && std::filesystem::exists(path, error)) return path.string();
  return absl::NotFoundError(absl::StrCat("no program ", name, " beside ", self.string()));
}

}  // namespace corbslam::services
