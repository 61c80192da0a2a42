// Gives every thread at least a megabyte of stack. The metrics' web server (libcivetweb) gives its
// threads 100 KiB, of which a sanitizer's thread-local storage and checks leave too little. The
// definition takes the place of the C library's, and calls it.
#include <dlfcn.h>
#include <pthread.h>

#include <algorithm>
#include <cstddef>

extern "C" int pthread_attr_setstacksize(pthread_attr_t* attributes, size_t bytes) noexcept {
  constexpr size_t kLeastBytes = size_t{1} << 20;
  using Function = int(pthread_attr_t*, size_t);
  static auto* const library =
      reinterpret_cast<Function*>(dlsym(RTLD_NEXT, "pthread_attr_setstacksize"));
  return library(attributes, std::max(bytes, kLeastBytes));
}
