#include "slam/util/named_thread.h"

#include <pthread.h>

namespace corbslam {

void NameThisThread(const char* name) { pthread_setname_np(pthread_self(), name); }

}  // namespace corbslam
