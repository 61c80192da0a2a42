// Tells ThreadSanitizer what abseil's mutexes do. Debian's abseil is built without it, so that
// every access under an absl::Mutex would look like a race. These definitions take the place of the
// library's, and call them.
#include <dlfcn.h>
#include <sanitizer/tsan_interface.h>

#include <cstdio>
#include <cstdlib>

#include "absl/synchronization/mutex.h"

// Debian 12's abseil lives in absl::debian3.
#define ABSEIL_MUTEX(name) "_ZN4absl7debian35Mutex" name
#define ABSEIL_CONDVAR(name) "_ZN4absl7debian37CondVar" name
#define CONDITION "ERKNS0_9ConditionE"
#define CONDITION_TIMEOUT "ERKNS0_9ConditionENS0_8DurationE"
#define CONDITION_DEADLINE "ERKNS0_9ConditionENS0_4TimeE"

namespace {

template <typename Function>
Function* Find(const char* symbol) {
  void* found = dlsym(RTLD_NEXT, symbol);
  if (found != nullptr) return reinterpret_cast<Function*>(found);
  std::fprintf(stderr, "abseil has no %s\n", symbol);
  std::abort();
}

// Some of the library's functions call others of them: only the outermost is told of.
thread_local bool inside = false;

template <typename Call>
void CallLibrary(Call call) {
  const bool before = inside;
  inside = true;
  call();
  inside = before;
}

template <typename Lock>
void Take(absl::Mutex* mutex, unsigned how, Lock lock) {
  if (inside) return lock();
  __tsan_mutex_pre_lock(mutex, how);
  CallLibrary(lock);
  __tsan_mutex_post_lock(mutex, how, 0);
}

template <typename Unlock>
void Leave(absl::Mutex* mutex, unsigned how, Unlock unlock) {
  if (inside) return unlock();
  __tsan_mutex_pre_unlock(mutex, how);
  CallLibrary(unlock);
  __tsan_mutex_post_unlock(mutex, how);
}

template <typename TryLock>
bool Try(absl::Mutex* mutex, unsigned how, TryLock try_lock) {
  if (inside) return try_lock();
  __tsan_mutex_pre_lock(mutex, how | __tsan_mutex_try_lock);
  bool taken = false;
  CallLibrary([&] { taken = try_lock(); });
  const unsigned outcome = taken ? 0 : __tsan_mutex_try_lock_failed;
  __tsan_mutex_post_lock(mutex, how | __tsan_mutex_try_lock | outcome, 0);
  return taken;
}

// Leaves the mutex to others for a while. Whoever waits holds it alone.
template <typename Wait>
bool WaitOn(absl::Mutex* mutex, Wait wait) {
  if (inside) return wait();
  __tsan_mutex_pre_unlock(mutex, 0);
  __tsan_mutex_post_unlock(mutex, 0);
  __tsan_mutex_pre_lock(mutex, 0);
  bool result = false;
  CallLibrary([&] { result = wait(); });
  __tsan_mutex_post_lock(mutex, 0, 0);
  return result;
}

using OnMutex = void(absl::Mutex*);
using TryOnMutex = bool(absl::Mutex*);
using OnCondition = void(absl::Mutex*, const absl::Condition&);
using OnTimeout = bool(absl::Mutex*, const absl::Condition&, absl::Duration);
using OnDeadline = bool(absl::Mutex*, const absl::Condition&, absl::Time);
using Wait = void(absl::CondVar*, absl::Mutex*);
using WaitTimeout = bool(absl::CondVar*, absl::Mutex*, absl::Duration);
using WaitDeadline = bool(absl::CondVar*, absl::Mutex*, absl::Time);

}  // namespace

namespace absl {
ABSL_NAMESPACE_BEGIN

Mutex::~Mutex() {
  static auto* const destroy = Find<OnMutex>(ABSEIL_MUTEX("D1Ev"));
  __tsan_mutex_destroy(this, __tsan_mutex_not_static);
  destroy(this);
}

void Mutex::Lock() ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const lock = Find<OnMutex>(ABSEIL_MUTEX("4LockEv"));
  Take(this, 0, [this] { lock(this); });
}

void Mutex::Unlock() ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const unlock = Find<OnMutex>(ABSEIL_MUTEX("6UnlockEv"));
  Leave(this, 0, [this] { unlock(this); });
}

bool Mutex::TryLock() ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const try_lock = Find<TryOnMutex>(ABSEIL_MUTEX("7TryLockEv"));
  return Try(this, 0, [this] { return try_lock(this); });
}

void Mutex::ReaderLock() ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const lock = Find<OnMutex>(ABSEIL_MUTEX("10ReaderLockEv"));
  Take(this, __tsan_mutex_read_lock, [this] { lock(this); });
}

void Mutex::ReaderUnlock() ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const unlock = Find<OnMutex>(ABSEIL_MUTEX("12ReaderUnlockEv"));
  Leave(this, __tsan_mutex_read_lock, [this] { unlock(this); });
}

bool Mutex::ReaderTryLock() ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const try_lock = Find<TryOnMutex>(ABSEIL_MUTEX("13ReaderTryLockEv"));
  return Try(this, __tsan_mutex_read_lock, [this] { return try_lock(this); });
}

void Mutex::LockWhen(const Condition& condition) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const lock = Find<OnCondition>(ABSEIL_MUTEX("8LockWhen" CONDITION));
  Take(this, 0, [&] { lock(this, condition); });
}

bool Mutex::LockWhenWithTimeout(const Condition& condition,
                                Duration timeout) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const lock =
      Find<OnTimeout>(ABSEIL_MUTEX("19LockWhenWithTimeout" CONDITION_TIMEOUT));
  bool met = false;
  Take(this, 0, [&] { met = lock(this, condition, timeout); });
  return met;
}

bool Mutex::LockWhenWithDeadline(const Condition& condition,
                                 Time deadline) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const lock =
      Find<OnDeadline>(ABSEIL_MUTEX("20LockWhenWithDeadline" CONDITION_DEADLINE));
  bool met = false;
  Take(this, 0, [&] { met = lock(this, condition, deadline); });
  return met;
}

void Mutex::Await(const Condition& condition) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const await = Find<OnCondition>(ABSEIL_MUTEX("5Await" CONDITION));
  (void)WaitOn(this, [&] {
    await(this, condition);
    return true;
  });
}

bool Mutex::AwaitWithTimeout(const Condition& condition,
                             Duration timeout) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const await = Find<OnTimeout>(ABSEIL_MUTEX("16AwaitWithTimeout" CONDITION_TIMEOUT));
  return WaitOn(this, [&] { return await(this, condition, timeout); });
}

bool Mutex::AwaitWithDeadline(const Condition& condition,
                              Time deadline) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const await =
      Find<OnDeadline>(ABSEIL_MUTEX("17AwaitWithDeadline" CONDITION_DEADLINE));
  return WaitOn(this, [&] { return await(this, condition, deadline); });
}

void CondVar::Wait(Mutex* mutex) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const wait = Find<::Wait>(ABSEIL_CONDVAR("4WaitEPNS0_5MutexE"));
  (void)WaitOn(mutex, [&] {
    wait(this, mutex);
    return true;
  });
}

bool CondVar::WaitWithTimeout(Mutex* mutex, Duration timeout) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const wait =
      Find<WaitTimeout>(ABSEIL_CONDVAR("15WaitWithTimeoutEPNS0_5MutexENS0_8DurationE"));
  return WaitOn(mutex, [&] { return wait(this, mutex, timeout); });
}

bool CondVar::WaitWithDeadline(Mutex* mutex, Time deadline) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  static auto* const wait =
      Find<WaitDeadline>(ABSEIL_CONDVAR("16WaitWithDeadlineEPNS0_5MutexENS0_4TimeE"));
  return WaitOn(mutex, [&] { return wait(this, mutex, deadline); });
}

ABSL_NAMESPACE_END
}  // namespace absl
