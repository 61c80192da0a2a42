// This library, preloaded into a program (LD_PRELOAD), makes a disk read-only under it: as long as
// the file FOLDER.read_only is there, whatever would change something in FOLDER
// (CORBSLAM_TEST_DISK) is refused with EROFS, also through files that are open. The system itself
// does so only after a disk's errors: it doesn't let anybody remount what is in use.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

// Returns null before the program has its environment: sanitizers open their logs earlier than
// that.
const char* Folder() { return std::getenv("CORBSLAM_TEST_DISK"); }

bool IsSwitchedOn() {
  if (Folder() == nullptr) return false;
  char path[4096];
  std::snprintf(path, sizeof(path), "%s.read_only", Folder());
  return access(path, F_OK) == 0;
}

bool IsInside(const char* path) {
  return std::strncmp(path, Folder(), std::strlen(Folder())) == 0 &&
         path[std::strlen(Folder())] == '/';
}

bool IsRefused(const char* path) { return IsSwitchedOn() && IsInside(path); }

bool IsRefused(int file) {
  if (!IsSwitchedOn()) return false;
  char link[64];
  std::snprintf(link, sizeof(link), "/proc/self/fd/%d", file);
  char path[4096] = {};
  return readlink(link, path, sizeof(path) - 1) > 0 && IsInside(path);
}

int Refuse() {
  errno = EROFS;
  return -1;
}

template <typename Function>
Function* Original(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

ssize_t write(int file, const void* bytes, size_t size) {
  static auto* const original = Original<ssize_t(int, const void*, size_t)>("write");
  return IsRefused(file) ? Refuse() : original(file, bytes, size);
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
  static auto* const original = Original<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  return IsRefused(file) ? Refuse() : original(file, bytes, size, offset);
}

int fsync(int file) {
  static auto* const original = Original<int(int)>("fsync");
  return IsRefused(file) ? Refuse() : original(file);
}

int fdatasync(int file) {
  static auto* const original = Original<int(int)>("fdatasync");
  return IsRefused(file) ? Refuse() : original(file);
}

int fallocate(int file, int mode, off_t offset, off_t size) {
  static auto* const original = Original<int(int, int, off_t, off_t)>("fallocate");
  return IsRefused(file) ? Refuse() : original(file, mode, offset, size);
}

int open(const char* path, int flags, ...) {
  static auto* const original = Original<int(const char*, int, ...)>("open");
  va_list rest;
  va_start(rest, flags);
  const auto mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  const bool writes = (flags & (O_CREAT | O_WRONLY | O_RDWR | O_TRUNC)) != 0;
  return writes && IsRefused(path) ? Refuse() : original(path, flags, mode);
}

int rename(const char* from, const char* to) noexcept {
  static auto* const original = Original<int(const char*, const char*)>("rename");
  return IsRefused(to) ? Refuse() : original(from, to);
}

int unlink(const char* path) noexcept {
  static auto* const original = Original<int(const char*)>("unlink");
  return IsRefused(path) ? Refuse() : original(path);
}

int mkdir(const char* path, mode_t mode) noexcept {
  static auto* const original = Original<int(const char*, mode_t)>("mkdir");
  return IsRefused(path) ? Refuse() : original(path, mode);
}

}  // extern "C"
#pragma GCC visibility pop
