// Measures what keyframes take uncoded and coded, by column, on the wire and in the journal, and
// how long that takes. The keyframes are what a robot uploads of each source, alone and in
// lockstep.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "map_store/archive/archive.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/value_fields.h"
#include "services/convert/limits.h"
#include "services/convert/map_update.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/coding/descriptor_streams.h"
#include "slam/coding/feature_coding.h"
#include "slam/coding/feature_columns.h"
#include "slam/util/status_macros.h"
#include "tests/bench/started_server.h"
#include "tests/replay/quantile.h"

namespace corbslam::tests {

using services::CameraBook;
using services::FeatureForm;
using services::kMaxKeypoints;
using services::kPartBytes;
using services::ToProto;

namespace {

// Returns the time of this thread's processor: other programs don't count.
double Now_ms() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

// Sums over all keyframes.
struct Row {
  size_t keyframes = 0;
  size_t features = 0;
  size_t plain = 0;
  size_t plain_descriptors = 0;
  size_t coded = 0;
  size_t coded_descriptors = 0;
  size_t without_disparities = 0;
  size_t journal_plain = 0;
  size_t journal_coded = 0;
  // Number of all points' descriptors.
  size_t points = 0;
  size_t coded_points = 0;
  std::vector<double> encode_ms;
  std::vector<double> decode_ms;
};

absl::Status AddKeyframe(const KeyframePayload& payload, Row& row) {
  v1::KeyframePayload plain;
  ToProto(payload, &plain);
  row.plain += plain.ByteSizeLong();
  row.plain_descriptors += plain.features().descriptors().size();
  const PictureSize picture = {static_cast<uint32_t>(payload.camera->width_px),
                               static_cast<uint32_t>(payload.camera->height_px)};
  FeatureColumns columns = ToColumns(payload.features);
  const double begin_ms = Now_ms();
  const auto coded = EncodeFeatures(columns, picture);
  const double middle_ms = Now_ms();
  if (!coded.has_value()) return absl::InternalError("a keyframe was not coded");
  ASSIGN_OR_RETURN(const FeatureColumns read, DecodeFeatures(*coded, kMaxKeypoints));
  row.decode_ms.push_back(Now_ms() - middle_ms);
  row.encode_ms.push_back(middle_ms - begin_ms);
  if (!(read == columns)) return absl::InternalError("a keyframe came back changed");
  ++row.keyframes;
  row.features += columns.size();
  row.coded += coded->size();
  for (const std::string& stream : EncodeDescriptors(columns.descriptors)) {
    row.coded_descriptors += stream.size();
  }
  // The store keeps this keyframe: the wire has rounded it.
  KeyframePayload kept;
  kept.camera = payload.camera;
  kept.features = FromColumns(columns);
  row.journal_coded += map_store::EncodeFeatures(kept).size();
  map_store::ArchiveWriter archive;
  archive(kept.features);
  row.journal_plain += archive.Take().size();
  columns.disparity_px128.clear();
  row.without_disparities += EncodeFeatures(columns, picture).value_or("").size();
  return absl::OkStatus();
}

absl::StatusOr<Row> Measure(const RecordedUploads& uploads) {
  Row row;
  CameraBook cameras;
  for (const MapUpdateBatch& batch : uploads) {
    for (const FullKeyframe& keyframe : batch.full_keyframes) {
      RETURN_IF_ERROR(AddKeyframe(*keyframe.payload, row));
    }
    for (const auto& part : ToProto(batch, cameras, kPartBytes, FeatureForm::kCoded)) {
      row.points += static_cast<size_t>(part.full_points().ids().index_deltas_size());
      row.coded_points += part.full_points().coded_descriptors().size();
      row.coded_points += part.full_points().descriptors().size();
    }
  }
  if (row.keyframes == 0 || row.points == 0) return absl::InternalError("nothing was uploaded");
  return row;
}

void Print(const std::string& source, const Row& row) {
  const auto mean = [&](size_t bytes) {
    return static_cast<double>(bytes) / static_cast<double>(row.keyframes);
  };
  std::printf("%s: %zu keyframes, %.0f features each; bytes of a keyframe, means\n", source.c_str(),
              row.keyframes, mean(row.features));
  std::printf("| column | uncoded | coded |\n| --- | --- | --- |\n");
  std::printf("| descriptors | %.0f | %.0f |\n", mean(row.plain_descriptors),
              mean(row.coded_descriptors));
  std::printf("| disparities | | %.0f |\n", mean(row.coded - row.without_disparities));
  std::printf("| positions, levels, angles | | %.0f |\n",
              mean(row.without_disparities - row.coded_descriptors));
  std::printf("| all, on the wire | %.0f | %.0f |\n", mean(row.plain), mean(row.coded));
  std::printf("| all, in the journal | %.0f | %.0f |\n", mean(row.journal_plain),
              mean(row.journal_coded));
  std::printf("| descriptor of a new map point | 32 | %.1f |\n",
              static_cast<double>(row.coded_points) / static_cast<double>(row.points));
  std::printf("encoding %.2f ms median, %.2f ms p99; decoding %.2f, %.2f (of the processor)\n\n",
              Quantile(row.encode_ms, 0.5), Quantile(row.encode_ms, 0.99),
              Quantile(row.decode_ms, 0.5), Quantile(row.decode_ms, 0.99));
  std::fflush(stdout);
}

absl::Status Run(const std::vector<std::string>& sources) {
  ASSIGN_OR_RETURN(const std::vector<RecordedUploads> recorded, RecordAll(sources));
  for (size_t i = 0; i < sources.size(); ++i) {
    ASSIGN_OR_RETURN(const Row row, Measure(recorded[i]));
    Print(sources[i], row);
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  std::vector<std::string> sources;
  CLI::App app("Bytes and times of coded features", "coded_features");
  app.add_option("--source", sources, "What robots have seen: kitti:DIR, tum:DIR, sim:WORLD, ...")
      ->required();
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(sources);
  if (status.ok()) return 0;
  std::fprintf(stderr, "coded_features: %s\n", status.ToString().c_str());
  return 1;
}
