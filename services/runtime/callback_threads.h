// Keeps gRPC's threads for reactors.
#ifndef CORBSLAM_SERVICES_RUNTIME_CALLBACK_THREADS_H_
#define CORBSLAM_SERVICES_RUNTIME_CALLBACK_THREADS_H_

namespace corbslam::services {

// Makes gRPC's threads last as long as the process. Without it gRPC ends these threads when the
// last channel or server that uses them goes, and in version 1.51 that sometimes aborts the process
// ("ref_counted.h: assertion failed: prior > 0", from grpc_cq_internal_unref in a nexting_thread).
// The caller calls it before the first channel or server. Thread-safe; more calls do nothing.
void KeepCallbackThreads();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_CALLBACK_THREADS_H_
