// Sets the upper bounds of our histograms' buckets.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_BUCKETS_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_BUCKETS_H_

#include <prometheus/histogram.h>

namespace corbslam::services {

using Buckets = prometheus::Histogram::BucketBoundaries;

// Returns bounds for calls, batches and the journal, in seconds: half a millisecond to half a
// minute.
inline Buckets ShortTimes_s() {
  return {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30};
}

// Returns bounds for fusion, in seconds: ten milliseconds to ten minutes.
inline Buckets LongTimes_s() {
  return {0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 120, 300, 600};
}

// Returns bounds for a frame, in seconds: they are fine around the time that cameras' rates leave.
inline Buckets FrameTimes_s() {
  return {0.005, 0.01, 0.015, 0.02, 0.025, 0.033, 0.04, 0.05, 0.067, 0.1, 0.2, 0.5, 1};
}

// Returns bounds for messages: 64 bytes to the limit of 4 MiB.
inline Buckets MessageSizes_bytes() {
  return {64, 256, 1024, 4096, 16384, 65536, 262144, 1048576, 4194304};
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_BUCKETS_H_
